"""The viewer of a robot that a node serves: real node, real Zenoh, real web server."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import zenoh
from support.browsers import HEIGHT, page_of, pixels
from support.nodes import wait_health, wait_mode
from support.processes import Served, Start, run_main, wait_alive
from support.viewers import Shown, browser, drag, showing, wait_until

from tauten.model import Robot, skin_of
from tauten.service.frames import RecordedRobot, ServedRobot
from tauten.service.process import StopFlag
from tauten.service.view import open_server
from tauten.service.view.playback import PlaybackSession
from tauten.service.wire import SKIN_FIELDS, Cause, Cloud, Mode, OperatorCommand, decode_cloud


@pytest.fixture
def shown(served: Served) -> Iterator[Shown]:
    """A viewer of the node, not armed, lit as users see it."""
    source = ServedRobot(served.session, "beam")
    source.await_surface()
    with showing(source, lit=True) as found:
        yield found


def high(beam: Robot) -> tuple[float, ...]:
    """A target above the tip."""
    x, y, z = beam.effector(beam.rest())[0].tolist()
    return x, y, z + 0.004


@pytest.mark.long
def test_the_robot_follows_while_armed_and_holds_when_the_browser_leaves(
    served: Served, shown: Shown, beam: Robot
) -> None:
    with browser(shown) as page:
        assert wait_until(lambda: shown.guard.browsers == 1)
        drag(page, high(beam))
        time.sleep(0.5)
        wait_mode(served, Mode.IDLE)  # not armed: nothing is sent
        shown.session.arm()
        drag(page, high(beam))
        wait_mode(served, Mode.RUN)

        def followed() -> bool:
            frame = shown.session.newest
            return frame is not None and frame.values[2] > 0.012

        assert wait_until(followed)
    wait_mode(served, Mode.HOLD, Cause.NO_TARGET)
    assert not shown.session.targets.armed


def test_the_surface_is_that_of_the_model(shown: Shown, beam: Robot) -> None:
    assert wait_until(lambda: shown.session.newest is not None)
    frame = shown.session.newest
    assert frame is not None
    skin = skin_of(beam)
    rest = beam.points(beam.rest())[skin.used]
    assert frame.geometry.vertices == pytest.approx(rest, abs=1e-5)
    assert frame.geometry.segments == pytest.approx(beam.actuator_segments(beam.rest()), abs=1e-5)


@pytest.mark.long
def test_the_surface_leaves_the_node_only_while_somebody_listens(served: Served) -> None:
    def published() -> float:
        values = wait_health(served, lambda found: "surface" in found)["surface"].values
        return float(values["published"])

    assert published() == 0.0
    heard = served.session.declare_subscriber(served.keys.surface, zenoh.handlers.RingChannel(100))
    found: list[Cloud] = []

    def arrived() -> bool:
        sample = heard.try_recv()
        if sample is not None:
            cloud = decode_cloud(bytes(sample.payload), SKIN_FIELDS)
            assert isinstance(cloud, Cloud)
            found.append(cloud)
        return len(found) >= 10

    assert wait_until(arrived, 120.0)  # a busy machine leaves the node no time for any
    assert np.diff([1e-9 * cloud.stamp for cloud in found]).min() > 0.015  # at most 30 a second
    heard.undeclare()
    assert wait_until(lambda: published() == published())  # of one second and the next


def test_the_buttons_reach_the_node(served: Served, shown: Shown) -> None:
    shown.session.source.command(OperatorCommand.STOP)
    wait_mode(served, Mode.STOP)
    shown.session.source.command(OperatorCommand.RESET)
    wait_mode(served, Mode.IDLE)


@pytest.mark.long
def test_a_node_that_is_started_again_does_not_move_the_robot(
    served: Served, shown: Shown, beam: Robot, beam_file: Path, run: Start
) -> None:
    """It was moved at once to where the target had been before, and the page said RUN without any node."""
    session = shown.session
    with browser(shown) as page:
        assert wait_until(lambda: shown.guard.browsers == 1)
        session.arm()
        drag(page, high(beam))
        wait_mode(served, Mode.RUN)
        served.process.process.kill()
        served.process.process.wait()
        assert wait_until(lambda: session.source.silence > 0.0)
        assert wait_until(lambda: not session.targets.armed)
        process = run("serve", beam_file, "--port", served.port)
        wait_alive(served.session, served.keys.token, process)
        assert wait_until(lambda: session.source.silence == 0.0)
        time.sleep(1.0)
        wait_mode(served, Mode.IDLE)
        session.arm()  # where the effector is
        wait_mode(served, Mode.RUN)


@pytest.mark.slow
def test_closing_the_page_of_a_real_browser_holds_the_node(served: Served, shown: Shown) -> None:
    with page_of(shown.origin, "Operate") as page:
        page.get_by_label("follow").dispatch_event("click")  # wherever the panel is by now
        wait_mode(served, Mode.RUN)
        page.close()
        wait_mode(served, Mode.HOLD, Cause.NO_TARGET)


@pytest.mark.long
def test_a_log_is_shown_and_exported(
    served: Served, shown: Shown, beam: Robot, beam_file: Path, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    with browser(shown) as page:
        assert wait_until(lambda: shown.guard.browsers == 1)
        shown.session.arm()
        drag(page, high(beam))
        wait_mode(served, Mode.RUN)
        time.sleep(2.0)
    assert served.process.end() == 0
    recorded = RecordedRobot(served.log, str(beam_file))
    assert recorded.notes == ()
    frames = [frame for frame in recorded.frames() if frame is not None]
    followed = [frame for frame in frames if frame.mode is Mode.RUN]
    assert recorded.look.error(followed[-1]) < 2.2e-3  # at rest 2.07 mm, for the sake of the middle
    assert followed[-1].geometry.vertices[:, 2].max() > 0.022  # bent upwards
    stop = StopFlag()
    with open_server(0, "log") as (server, guard):
        session = PlaybackSession(recorded, server, guard)
        assert wait_until(lambda: session.run(stop, 0.5) > 20)  # it counts on from call to call
        drawn = server.scene._handle_from_node_name
        assert "/strain/0" not in drawn
        session._panel.viewing._strain.value = True  # type: ignore[misc]
        session.run(stop, 0.5)
        assert "/strain/0" in drawn and not drawn["/skin"].visible, "as in a simulation"
    html = tmp_path / "run.html"
    assert run_main("view", served.log, "--against", beam_file, "--export", html) == 0
    text = html.read_text()
    assert f"{len(frames)} frames" in capsys.readouterr().out
    assert "__VISER_EMBED_DATA__" in text
    assert "http://" not in text.split("__VISER_EMBED_DATA__")[1].split("</script>")[0]
    with page_of(html.as_uri()) as page_:
        assert wait_until(lambda: page_.get_by_text("1x").count() > 0)
        assert wait_until(lambda: bool(pixels(page_)[HEIGHT - 5, 5].mean() > 0.7)), "it is light"
        text = page_.get_by_text("effector", exact=True)
        assert text.evaluate("one => getComputedStyle(one).color") == "rgb(34, 34, 34)"


def test_a_log_of_another_robot_says_so(
    served: Served, beam_file: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    wait_mode(served, Mode.IDLE)
    assert served.process.end() == 0
    other = tmp_path / "other.toml"
    other.write_text(beam_file.read_text().replace("1e6", "2e6"))
    (tmp_path / "beam.vtu").write_bytes((beam_file.parent / "beam.vtu").read_bytes())
    recorded = RecordedRobot(served.log, str(other))
    assert "has changed since the log was made" in recorded.notes[0]
    assert "--against" in recorded.notes[0]
