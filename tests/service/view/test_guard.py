"""Attacks on the viewer: foreign pages, tunnels, messages out of limits, a second browser."""

from __future__ import annotations

import asyncio
import math
import shutil
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import viser
from support.viewers import Shown, browser, drag, send, showing, wait_until
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection

from tauten.model import Robot
from tauten.service.frames import SimulatedRobot
from tauten.service.setup import load_setup
from tauten.service.view import open_server
from tauten.service.view.web.server import LoopEvent, ViewError
from tauten.service.wire import Mode, reach_of

CLICK: dict[str, object] = {
    "event_type": "click",
    "ray_origin": (0.05, -1.0, 0.01),
    "ray_direction": (0.0, 1.0, 0.0),
    "screen_pos": ((0.5, 0.5),),
    "modifier": None,
}
NEAR = (0.1, 0.01, 0.013)  # 3 mm above the tip at rest


@pytest.fixture
def shown(beam_file: Path, beam: Robot) -> Iterator[Shown]:
    """The small robot, simulated; not armed."""
    setups = [load_setup(beam_file, rate=20.0) for _ in range(2)]
    with showing(SimulatedRobot(*setups)) as found:
        yield found


@pytest.mark.parametrize(
    "origin",
    [
        "https://evil.example",
        "http://evil.example:8080",
        "http://127.0.0.1.evil.example:8080",
        "http://localhost.evil.example",
        "null",
        None,
    ],
)
def test_a_foreign_origin_is_refused(refusing: Shown, origin: str | None) -> None:
    with pytest.raises(InvalidStatus) as refused, browser(refusing, origin):
        pass
    assert refused.value.response.status_code == 403
    assert refusing.guard.browsers == 0


def test_only_this_computer_can_connect(refusing: Shown) -> None:
    sockets = refusing.server._websock_server._live_connections  # viser has no other way to look
    with browser(refusing):
        assert wait_until(lambda: len(sockets) == 1)
        address = next(iter(sockets.values())).local_address
    assert address[0] == "127.0.0.1"


def test_no_browser_opens_a_tunnel(refusing: Shown) -> None:
    with browser(refusing) as page:
        send(page, "ShareUrlRequest")
        assert wait_until(lambda: refusing.guard.refused["type ShareUrlRequest"] == 1)
    assert refusing.server.request_share_url() is None
    assert refusing.server._share_tunnel is None


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e300, True, "0", None, [0.0]])
def test_what_is_no_position_is_refused(refusing: Shown, value: object) -> None:
    refusing.session.arm()
    before = refusing.session.targets.values
    with browser(refusing) as page:
        drag(page, (value, 0.0, 0.0))  # type: ignore[arg-type]
        assert wait_until(lambda: refusing.guard.refused.total() == 1)
        assert np.array_equal(refusing.session.targets.values, before)


def upload(page: ClientConnection, component: str, content: bytes, parts: int = 1) -> None:
    """Send a file to an input of the panel."""
    same = {"source_component_uuid": component, "transfer_uuid": "0"}
    send(
        page, "FileTransferStartUpload", filename="x.csv", mime_type="text/csv", part_count=parts,
        size_bytes=len(content), **same,
    )  # fmt: skip
    send(page, "FileTransferPart", part_index=0, content=content, **same)


def test_files_are_small_and_for_the_waypoints_only(refusing: Shown) -> None:
    refusing.session.arm()
    (component,) = refusing.session.program.uploads
    waypoints = refusing.session.program.waypoints
    with browser(refusing) as page:
        upload(page, component, b"x,y,z\n" + b"0.1,0.01,0.01\n" * 4000)
        assert wait_until(lambda: refusing.guard.refused.total() == 2)
        upload(page, component, b"x,y,z\n0.1,0.01,0.01\n", parts=2**20)
        assert wait_until(lambda: refusing.guard.refused.total() == 3)
        assert len(waypoints) == 0
        upload(page, component, b"x,y,z\n0.1,0.01,0.01\n")
        assert wait_until(lambda: len(waypoints) == 1)
    waypoints.clear()


PUSH: dict[str, object] = {
    "name": "/skin",
    "phase": "update",
    "instance_index": None,
    "start_position": (0.1, 0.01, 0.01),
    "start_screen_pos": (0.5, 0.5),
    "end_position": (0.1, 0.01, 0.05),
    "end_screen_pos": (0.5, 0.4),
    "button": "left",
    "modifier": "cmd/ctrl",
    "owner": "",
}


@pytest.mark.parametrize(
    "change",
    [
        {"phase": "for ever"},
        {"end_position": (0.1, 0.01, math.inf)},
        {"end_position": (0.1, 0.01)},
        {"end_position": None},
        {"button": "right"},
        {"modifier": None},
    ],
)
def test_only_drags_with_ctrl_push(refusing: Shown, change: dict[str, object]) -> None:
    with browser(refusing) as page:
        send(page, "SceneNodeDragMessage", **(PUSH | change))
        assert wait_until(lambda: refusing.guard.refused.total() == 1)


def test_a_push_ends_with_its_browser_and_limits_hold(shown: Shown, beam: Robot) -> None:
    def height() -> float:
        frame = shown.session.newest
        return 0.0 if frame is None else float(frame.values[2])

    limits = beam.limits
    with browser(shown) as page:
        send(page, "SceneNodeDragMessage", **(PUSH | {"end_position": (0.1, 0.01, 1e6)}))
        assert wait_until(lambda: height() > 0.011)
        frame = shown.session.newest
        assert frame is not None
        assert height() < 0.01 + beam.size, "the spring is no longer than half the robot"
        assert (frame.position <= limits.position_max + 1e-9).all()
        assert (frame.effort <= limits.effort_max * (1 + 1e-6)).all()
    assert wait_until(lambda: abs(height() - 0.01) < 2e-4)


def test_a_target_beyond_reach_is_clamped(shown: Shown, beam: Robot) -> None:
    shown.session.arm()
    with browser(shown) as page:
        drag(page, (9.0, 9.0, 9.0))
        rest = beam.effector(beam.rest())[0]
        targets = shown.session.targets
        assert wait_until(lambda: bool(np.abs(targets.of(0)[:3] - rest).max() > 1e-6))
        distance = np.linalg.norm(shown.session.targets.of(0)[:3] - rest)
    assert 0.99 * reach_of(beam.size) < distance <= reach_of(beam.size)


def test_inputs_keep_their_limits_and_the_rest_of_the_panel_cannot_be_changed(
    refusing: Shown,
) -> None:
    sliders = refusing.server.gui._gui_input_handle_from_uuid
    with browser(refusing) as page:
        for uuid in list(sliders):
            send(page, "GuiUpdateMessage", uuid=uuid, updates={"max": 1e5, "callback": 1})
            send(page, "GuiUpdateMessage", uuid=uuid, updates={"value": 1e9})
        assert wait_until(lambda: refusing.guard.refused.total() == 2 * len(sliders))
        upload(page, next(iter(sliders)), b"x,y,z")
        send(page, "RunJavascriptMessage", source="alert(1)")
        page.send("text")
        page.send(b"\xc1 no msgpack")
        assert wait_until(lambda: refusing.guard.refused.total() == 2 * len(sliders) + 5)
        page.send(b"\x00" * 2**24)  # beyond the largest message: the connection is closed
        assert wait_until(lambda: refusing.guard.browsers == 0)


@pytest.mark.parametrize(
    "change",
    [
        {"event_type": "rect-select"},
        {"ray_origin": None},
        {"ray_direction": (0.0, 1.0)},
        {"ray_direction": (0.0, math.nan, 0.0)},
    ],
)
def test_what_is_no_click_is_refused(refusing: Shown, change: dict[str, object]) -> None:
    with browser(refusing) as page:
        send(page, "ScenePointerMessage", **{**CLICK, **change})
        assert wait_until(lambda: refusing.guard.refused.total() == 1)


def test_clicks_draw_only_where_it_is_allowed(beam_file: Path, beam: Robot, tmp_path: Path) -> None:
    file = Path(shutil.copytree(beam_file.parent, tmp_path / "own")) / beam_file.name
    text = file.read_bytes()
    with (
        showing(SimulatedRobot(load_setup(file), load_setup(file)), file) as shown,
        browser(shown) as page,
    ):
        cable, panel = shown.session.cable, shown.session._panel
        assert cable is not None and panel._drawing is not None
        before = shown.session.newest
        send(page, "ScenePointerMessage", **CLICK)
        assert wait_until(lambda: shown.session.newest is not before)
        assert len(cable) == 0  # *draw* is off
        panel._drawing.value = True  # type: ignore[misc]

        def clicked() -> bool:
            send(page, "ScenePointerMessage", **CLICK)
            return wait_until(lambda: len(cable) > 1, 1.0)

        assert wait_until(clicked)
        assert cable.rest[0] == pytest.approx([0.05, 0.0, 0.01], abs=1e-6)
        for name in ("lower", "a b", "../x", 'x"\nrate = 1e9 #', ""):
            assert cable.save(name).startswith("not saved: ")
    assert file.read_bytes() == text


def test_a_second_browser_looks_on(shown: Shown, beam: Robot) -> None:
    shown.session.arm()
    with browser(shown) as first:
        assert wait_until(lambda: shown.guard.browsers == 1)
        with browser(shown) as second:
            assert wait_until(lambda: shown.guard.browsers == 2)
            drag(second, (0.1, 0.01, 0.02))
            assert wait_until(lambda: shown.guard.refused["not the operator"] == 1)
            drag(first, NEAR)
            assert wait_until(lambda: tuple(shown.session.targets.of(0)[:3]) == NEAR)
        assert wait_until(lambda: shown.guard.browsers == 1)
        assert shown.session.targets.armed  # the one who looks on has left


def pressed(shown: Shown, page: ClientConnection, value: object) -> None:
    """Press each button of the panel that takes a value."""
    for uuid in list(shown.server.gui._gui_input_handle_from_uuid):
        send(page, "GuiUpdateMessage", uuid=uuid, updates={"value": value})


def mode(shown: Shown) -> Mode | None:
    frame = shown.session.newest
    return None if frame is None else frame.mode


def test_every_browser_may_stop_and_hold_and_nothing_else(shown: Shown) -> None:
    shown.session.arm()
    with browser(shown), browser(shown) as second:
        assert wait_until(lambda: shown.guard.browsers == 2 and mode(shown) is Mode.RUN)
        inputs = len(shown.server.gui._gui_input_handle_from_uuid)
        for value in ("enable", "reset", "set", "clear", "1/10", 5.0, False, [True], {"a": True}):
            pressed(shown, second, value)
        send(second, "GuiUpdateMessage", uuid="x", updates={})
        assert wait_until(lambda: shown.guard.refused["not the operator"] == 9 * inputs + 1)
        assert mode(shown) is Mode.RUN
        pressed(shown, second, "hold")
        assert wait_until(lambda: mode(shown) is Mode.HOLD)
        pressed(shown, second, True)
        assert wait_until(lambda: mode(shown) is Mode.STOP)
        assert not shown.session.targets.armed
        assert wait_until(lambda: shown.guard.refused["not the operator"] == 11 * inputs - 1)


def test_a_browser_that_looks_on_is_told_so(shown: Shown) -> None:
    with browser(shown) as first:
        assert wait_until(lambda: len(shown.server.get_clients()) == 1)
        with browser(shown):
            assert wait_until(lambda: len(shown.session._panel._notices) == 1)
            (number,) = shown.session._panel._notices
            assert number == max(shown.server.get_clients())
            assert "stop" in shown.session._panel._notices[number].content
            first.close()
            assert wait_until(lambda: not shown.session._panel._notices)  # it operates now


def test_the_robot_is_disarmed_when_the_operator_leaves(shown: Shown) -> None:
    with browser(shown) as first, browser(shown) as second:
        assert wait_until(lambda: shown.guard.browsers == 2)
        shown.session.arm()
        drag(first, NEAR)
        assert wait_until(lambda: tuple(shown.session.targets.of(0)[:3]) == NEAR)
        first.close()
        assert wait_until(lambda: not shown.session.targets.armed)
        # the one who looked on operates now, and has to arm first
        drag(second, (0.1, 0.01, 0.02))
        assert wait_until(lambda: shown.guard.browsers == 1)
        assert shown.session.targets.goal() is None


@contextmanager
def frozen(shown: Shown) -> Iterator[socket.socket]:
    """A browser that has connected and stands still: its computer sleeps, or its tunnel is cut."""
    port = shown.server.get_port()
    request = (
        f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        f"Origin: {shown.origin}\r\nSec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n"
        f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: viser-v{viser.__version__}\r\n\r\n"
    )
    with socket.create_connection(("127.0.0.1", port)) as connection:
        connection.sendall(request.encode())
        yield connection


def seconds_to_disarm(shown: Shown) -> float:
    """Time for which a robot follows a browser that stands still."""
    with frozen(shown):
        assert wait_until(lambda: shown.guard.browsers == 1)
        shown.session.arm()
        begin = time.monotonic()
        assert wait_until(lambda: not shown.session.targets.armed)
        seconds = time.monotonic() - begin
    assert wait_until(lambda: shown.guard.browsers == 0)
    return seconds


def test_a_browser_that_stands_still_is_not_followed(shown: Shown) -> None:
    """websockets alone waits 10 s more for a goodbye that never comes."""
    assert seconds_to_disarm(shown) < 8.0
    assert shown.session.targets.goal() is None


@pytest.mark.realtime
def test_a_browser_that_stands_still_is_not_followed_after_two_seconds(shown: Shown) -> None:
    for _ in range(3):
        assert 1.0 < seconds_to_disarm(shown) < 2.1


@pytest.mark.long
def test_a_browser_that_answers_stays(shown: Shown) -> None:
    with browser(shown) as page:
        assert wait_until(lambda: shown.guard.browsers == 1)
        time.sleep(2.5)  # longer than a silence; it answers all pings
        shown.session.arm()
        drag(page, NEAR)
        assert wait_until(lambda: tuple(shown.session.targets.of(0)[:3]) == NEAR)
        assert shown.session.targets.armed


def test_a_port_in_use_is_an_error_that_names_the_next_step() -> None:
    with open_server(0, "first") as (server, _):
        port = server.get_port()
        with (
            pytest.raises(ViewError, match=f"port {port} .* is taken .*--web-port"),
            open_server(port, "second"),
        ):
            pass


def test_messages_wake_the_loop_of_the_server_from_its_own_thread_only(shown: Shown) -> None:
    """`asyncio.Event.set` may raise in another thread, and would end the viewer."""
    event = shown.server._websock_server._broadcast_buffer.message_event
    assert isinstance(event, LoopEvent)
    alone = LoopEvent()
    alone.set()
    assert not alone.is_set()

    async def in_loop() -> bool:
        alone.set()
        return await asyncio.wait_for(alone.wait(), 1.0)

    assert asyncio.run(in_loop())
