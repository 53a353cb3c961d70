"""The viewer in a real browser: it shows the robot, the mouse moves it, the stop button stops it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.image
import numpy as np
import pytest
from support.browsers import HEIGHT, WIDTH, on_page, page_of, pixels
from support.viewers import Shown, showing, wait_until

from tauten.model import Robot
from tauten.service.frames import SimulatedRobot
from tauten.service.setup import load_setup
from tauten.service.wire import Cause, Mode

if TYPE_CHECKING:
    from playwright.sync_api import Page


@pytest.fixture(scope="module")
def shown(beam_file: Path, beam: Robot) -> Iterator[Shown]:
    """The small robot, simulated; it follows. A browser without a graphics card draws ten times a second."""
    setups = [load_setup(beam_file, rate=10.0) for _ in range(2)]
    with showing(SimulatedRobot(*setups)) as found:
        yield found


@pytest.fixture(scope="module")
def opened(shown: Shown) -> Iterator[Page]:
    """Its page, which takes a browser many seconds to draw."""
    with page_of(shown.origin, "Operate") as found:
        yield found


@pytest.fixture
def page(opened: Page, shown: Shown) -> Page:
    """Its page, while the robot follows."""
    shown.session.arm()
    assert wait_until(lambda: shown.session.newest is not None)
    return opened


def test_the_robot_is_seen(page: Page, shown: Shown) -> None:
    def coloured() -> int:
        """Pixels left of the panel that are neither white nor grey."""
        picture = pixels(page)[HEIGHT // 4 :, : WIDTH - 400]
        return int((np.ptp(picture, axis=2) > 0.05).sum())

    some = WIDTH * HEIGHT // 128
    assert wait_until(lambda: coloured() > some, 60.0)
    shown.server.scene.set_global_visibility(False)
    assert wait_until(lambda: coloured() < some, 60.0)
    shown.server.scene.set_global_visibility(True)


@pytest.mark.long
def test_the_mouse_moves_the_target_and_the_robot(page: Page, shown: Shown, beam: Robot) -> None:
    rest = beam.effector(beam.rest())[0]
    grip = rest + np.array([0.0, 0.0, 0.2 * beam.size])  # on the arrow upwards
    (client,) = shown.server.get_clients().values()

    def drawn() -> bool:
        """Whether the arrow is seen: before, the page takes it for one at the origin of the scene."""
        x, y = (round(one) for one in on_page(grip, client.camera.position, client.camera.look_at))
        near = pixels(page)[y - 5 : y + 6, x - 5 : x + 6]
        return bool((near[..., 2] > near[..., 0] + 0.4).any())  # it is blue

    def dragged() -> bool:
        """Drag the arrow by 30 pixels."""
        x, y = on_page(grip, client.camera.position, client.camera.look_at)
        page.mouse.move(x, y)
        time.sleep(0.5)
        page.mouse.down()
        for step in range(10):
            page.mouse.move(x, y - 3.0 * (step + 1))
            time.sleep(0.05)
        page.mouse.up()
        return bool(shown.session.targets.of(0)[2] > rest[2] + 1e-3)

    assert wait_until(drawn, 120.0)
    assert wait_until(dragged, 60.0)
    target = shown.session.targets.of(0)[:3]
    assert abs(target[0] - rest[0]) < 1e-9  # along the arrow only

    def followed() -> bool:
        frame = shown.session.newest
        return frame is not None and frame.values[2] > rest[2] + 1e-3

    assert wait_until(followed)


@pytest.mark.long
def test_the_stop_button_stops(page: Page, shown: Shown) -> None:
    assert wait_until(lambda: mode_of(shown) is Mode.RUN)
    page.get_by_role("button", name="stop").click()
    assert wait_until(lambda: mode_of(shown) is Mode.STOP)
    assert not shown.session.targets.armed

    def ready() -> bool:
        """Press reset, which is possible once the cables are slack."""
        page.get_by_role("button", name="reset").click()
        return mode_of(shown) is Mode.IDLE

    assert wait_until(ready)


@pytest.mark.long
def test_a_slider_locks_an_actuator_within_its_limits(page: Page, shown: Shown) -> None:
    first = shown.session.source.look.robot.actuators[0]
    slider = page.get_by_role("slider", name="").nth(1)

    def unfolded() -> bool:
        page.get_by_text("Actuators", exact=True).first.click()
        return wait_until(slider.is_visible, 20.0)

    assert wait_until(unfolded, 60.0)
    slider.focus()
    slider.press("End")
    assert wait_until(lambda: shown.session.source.locked == {first.name})
    assert wait_until(lambda: mode_of(shown) is Mode.RUN)

    def at_limit() -> bool:
        frame = shown.session.newest
        return frame is not None and frame.position[0] <= first.position[1]

    assert wait_until(at_limit)
    box = page.get_by_label("locked").first
    assert wait_until(box.is_checked)
    box.press("Space")
    assert wait_until(lambda: not shown.session.source.locked)


@pytest.mark.long
def test_waypoints_are_a_program(page: Page, shown: Shown) -> None:
    assert wait_until(lambda: mode_of(shown) is Mode.RUN)
    page.get_by_text("Waypoints").first.click()
    waypoints = shown.session.program.waypoints
    page.get_by_role("button", name="set", exact=True).click()
    assert wait_until(lambda: len(waypoints) == 1)
    with page.expect_download() as download:
        page.get_by_role("button", name="save").click()
    lines = Path(download.value.path()).read_text().splitlines()
    assert lines[0] == "t,x,y,z"
    assert len(lines) == 2
    more = "x,y,z\n" + "\n".join(f"0.1,0.01,{z}" for z in (0.011, 0.012, 0.013))
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="load CSV").click()
    chooser.value.set_files({"name": "three.csv", "mimeType": "text/csv", "buffer": more.encode()})
    assert wait_until(lambda: len(waypoints) == 3)
    page.get_by_role("button", name="up", exact=True).click()
    assert wait_until(lambda: waypoints.points[1, 2] == 0.013), "the last one was chosen"
    page.get_by_role("button", name="remove", exact=True).click()
    assert wait_until(lambda: waypoints.points[:, 2].tolist() == [0.011, 0.012])
    page.get_by_role("button", name="go", exact=True).click()
    assert wait_until(lambda: bool(abs(shown.session.targets.of(0)[2] - 0.012) < 1e-6))
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="load CSV").click()
    chooser.value.set_files({"name": "bad.csv", "mimeType": "text/csv", "buffer": b"x,y\n1,2"})
    page.get_by_text("bad.csv: line 1: found").wait_for()
    page.get_by_role("button", name="clear", exact=True).click()
    assert wait_until(lambda: len(waypoints) == 0)


@pytest.mark.long
def test_the_mouse_pulls_the_simulated_robot_with_ctrl(
    page: Page, shown: Shown, beam: Robot
) -> None:
    (client,) = shown.server.get_clients().values()
    rest = beam.effector(beam.rest())[0]
    free = np.array([0.088, 0.0, 0.01])  # on the skin, between the arrows of the two gizmos
    x, y = on_page(free, client.camera.position, client.camera.look_at)

    def pulled() -> bool:
        """Pull the skin upwards; a page takes drags of it once it has drawn it."""
        page.mouse.move(x, y)
        page.keyboard.down("Control")
        page.mouse.down()
        for step in range(10):
            page.mouse.move(x, y - 8.0 * (step + 1))
            time.sleep(0.05)
        found = wait_until(lambda: height() > rest[2] + 1e-3, 10.0)
        page.mouse.up()
        page.keyboard.up("Control")
        return found

    def height() -> float:
        frame = shown.session.newest
        return rest[2] if frame is None else float(frame.values[2])

    shown.session.targets.put(0, rest)
    assert wait_until(pulled, 120.0)
    assert wait_until(lambda: abs(height() - rest[2]) < 1e-3), "it springs back"


@pytest.mark.long
def test_the_past_is_one_time_and_nothing_is_dragged_there(page: Page, shown: Shown) -> None:
    gizmo = shown.server.scene._handle_from_node_name["/gizmos/tip"]
    page.get_by_label("pause").click(force=True)
    page.get_by_text("PAUSED").wait_for()
    assert wait_until(lambda: stands_still(shown))
    slider = page.get_by_role("slider").first
    slider.focus()
    for _ in range(20):
        slider.press("ArrowLeft")
    page.get_by_text("PAST:").wait_for()
    assert wait_until(lambda: not gizmo.visible)
    page.wait_for_timeout(2000.0)  # the slider sends its last value late, which pauses
    page.get_by_role("button", name="now", exact=True).click()
    page.get_by_text("follows the target").wait_for()
    assert wait_until(lambda: gizmo.visible)


@pytest.mark.long
def test_the_camera_looks_from_above_and_the_page_is_dark(page: Page, shown: Shown) -> None:
    (client,) = shown.server.get_clients().values()
    page.get_by_role("button", name="top", exact=True).click()

    def from_above() -> bool:
        away = client.camera.position - client.camera.look_at
        return bool(away[2] > 0.99 * np.linalg.norm(away))

    assert wait_until(from_above)
    light = pixels(page)[HEIGHT - 5, 5].mean()
    page.get_by_role("button", name="dark", exact=True).click()
    assert wait_until(lambda: pixels(page)[HEIGHT - 5, 5].mean() < 0.3 < light, 60.0)
    page.get_by_role("button", name="light", exact=True).click()
    page.get_by_role("button", name="fit", exact=True).click()
    assert wait_until(lambda: not from_above())


@pytest.mark.long
def test_a_target_out_of_reach_is_said_and_the_nearest_point_shown(
    page: Page, shown: Shown, beam: Robot
) -> None:
    far = beam.effector(beam.rest())[0] + np.array([0.05, 0.0, 0.0])  # along the beam
    shown.session.targets.put(0, far)
    page.get_by_text("the target is out of reach").wait_for()
    assert "/nearest" in shown.server.scene._handle_from_node_name
    shown.session.targets.put(0, beam.effector(beam.rest())[0])
    page.get_by_text("follows the target").wait_for()
    assert wait_until(lambda: "/nearest" not in shown.server.scene._handle_from_node_name)


@pytest.mark.long
def test_a_picture_and_a_film_are_saved(page: Page, shown: Shown) -> None:
    with page.expect_download() as download:
        page.get_by_role("button", name="PNG", exact=True).click()
    picture = matplotlib.image.imread(download.value.path())
    assert download.value.suggested_filename == "beam.png"
    assert picture.shape[1] == WIDTH
    assert picture.shape[0] > HEIGHT, "the legend is below the picture"
    assert np.ptp(picture[: HEIGHT // 2, :, :3], axis=2).max() > 0.05, "the robot is in it"
    with page.expect_download() as download:
        page.get_by_role("button", name="film", exact=True).click()
    text = Path(download.value.path()).read_text(encoding="utf-8")
    assert download.value.suggested_filename == "beam.html"
    assert "cells of the ground: 10 mm" in text
    assert "base, which is held" in text, "its legend"
    assert "contact force" not in text, "nothing touches"


def test_the_robot_holds_when_the_page_is_closed(page: Page, shown: Shown) -> None:
    assert wait_until(lambda: mode_of(shown) is Mode.RUN)
    page.close()
    assert wait_until(lambda: mode_of(shown) is Mode.HOLD)
    frame = shown.session.newest
    assert frame is not None
    assert frame.cause is Cause.NO_TARGET


def mode_of(shown: Shown) -> Mode | None:
    """Mode in the newest frame."""
    frame = shown.session.newest
    return None if frame is None else frame.mode


def stands_still(shown: Shown) -> bool:
    """Whether no frame has come for a while."""
    before = shown.session.newest
    time.sleep(0.5)
    return shown.session.newest is before
