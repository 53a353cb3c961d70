"""The page around the picture: its colours are those that the browser prefers, and no number is cut."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from support.browsers import FEW_FRAMES, HEIGHT, WIDTH, page_of, pixels
from support.viewers import wait_until

from tauten.service.frames import SimulatedRobot
from tauten.service.setup import load_setup
from tauten.service.view import open_server
from tauten.service.view.export import write_html
from tauten.service.view.panel import ViewPanel
from tauten.service.view.words import Words

if TYPE_CHECKING:
    from playwright.sync_api import Page

LONG = (
    "the simulated robot moves otherwise than the model that decides: tendon1a 16.3 N, decided 14.9 N",
    "limits cannot all be met: actuators come as near to them as they can",
)
CUT = "one => one.scrollWidth > one.clientWidth"


@pytest.fixture(scope="module")
def panel(beam_file: Path) -> Iterator[tuple[ViewPanel, str]]:
    """A panel without a scene, and its address."""
    look = SimulatedRobot(*(load_setup(beam_file, rate=10.0) for _ in range(2))).look
    with open_server(0, "test") as (server, _):
        yield ViewPanel(server, look, targets=None), f"http://127.0.0.1:{server.get_port()}"


@pytest.fixture(scope="module")
def page(panel: tuple[ViewPanel, str]) -> Iterator[Page]:
    with page_of(panel[1], "Time") as found:
        yield found


def is_dark(page: Page) -> bool:
    """Whether the background is."""
    return bool(pixels(page)[HEIGHT - 5, 5].mean() < 0.3)


@pytest.mark.long
@pytest.mark.parametrize("last", [9.98, 123.46, 9999.98])
def test_no_time_of_a_long_run_is_cut(
    panel: tuple[ViewPanel, str], page: Page, last: float
) -> None:
    panel[0].show_time(0.0, last, last)
    field = page.locator(".mantine-NumberInput-input").first
    assert wait_until(lambda: field.input_value() == f"{last:g}")
    assert not field.evaluate(CUT)


@pytest.mark.long
def test_buttons_stay_where_they_are_whatever_is_said(
    panel: tuple[ViewPanel, str], page: Page
) -> None:
    """The stop button moved by a line with each sentence about the robot that came and went."""
    button = page.get_by_role("button", name="now", exact=True)
    places: list[float] = []

    def place() -> float:
        box = button.bounding_box()
        assert box is not None
        return box["y"]

    def still() -> bool:
        """Whether it moves no more: the page draws once a second."""
        before = place()
        page.wait_for_timeout(2_500.0)
        return abs(place() - before) < 0.1

    for words in (Words(), Words("RUN"), Words("last words", "advice " * 40, ("a sentence",) * 30)):
        panel[0].say(words)
        if words.title:
            page.get_by_text(words.title).wait_for()
        assert wait_until(still)
        places.append(place())
    assert max(places) - min(places) < 1.0  # pixels


@pytest.mark.long
def test_four_long_sentences_are_seen_without_scrolling(
    panel: tuple[ViewPanel, str], page: Page
) -> None:
    """The last of them was cut, and headless as on a Mac nothing showed that there is more."""
    said = ("at the limit: tendon1a, tendon1b, tendon2c, tendon3a", *LONG, "3 contact points push")
    for words in (
        Words(
            "RUN: the target is out of reach", "tip stays 12.3 mm away, at the nearest point", said
        ),
        Words(
            "HOLD: the actuators do not move",
            "a measurement is not plausible: check the camera, then press “enable”",
            ("4.5 mm from the target", *LONG),
        ),
    ):
        panel[0].say(words)
        title = page.get_by_text(words.title)
        title.wait_for()
        assert (
            title.evaluate(
                "one => (box => box.scrollHeight - box.clientHeight)(one.closest('[style*=overflow-y]'))"
            )
            <= 0
        )


@pytest.mark.long
def test_a_page_is_as_its_browser_prefers_until_somebody_chooses(page: Page) -> None:
    assert not is_dark(page)
    page.emulate_media(color_scheme="dark")
    assert wait_until(lambda: is_dark(page))
    page.emulate_media(color_scheme="light")
    assert wait_until(lambda: not is_dark(page))
    page.get_by_role("button", name="dark", exact=True).click()
    assert wait_until(lambda: is_dark(page))
    page.emulate_media(color_scheme="dark")
    page.emulate_media(color_scheme="light")
    page.wait_for_timeout(1_000.0)
    assert is_dark(page)
    page.emulate_media(color_scheme="dark")
    page.reload()
    assert wait_until(lambda: page.get_by_text("Time").count() > 0 and is_dark(page))


@pytest.mark.long
def test_a_film_is_as_its_browser_prefers(page: Page, beam_file: Path, tmp_path: Path) -> None:
    """Dark here, light in `test_served`."""
    robot = SimulatedRobot(*(load_setup(beam_file, rate=10.0) for _ in range(2)))
    frame = robot.advance(robot.look.robot.rest, True)
    assert frame is not None
    file = tmp_path / "film.html"
    assert write_html(robot.look, [frame], file) == 1
    browser = page.context.browser
    assert browser is not None
    shown = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, color_scheme="dark")
    shown.add_init_script(FEW_FRAMES)
    shown.goto(file.as_uri())
    text = shown.get_by_text("effector", exact=True)
    assert wait_until(lambda: is_dark(shown))
    assert text.evaluate("one => getComputedStyle(one).color") == "rgb(221, 221, 221)"
    shown.close()


@pytest.mark.long
def test_an_address_of_no_page_changes_none(page: Page, panel: tuple[ViewPanel, str]) -> None:
    page.emulate_media(color_scheme="light")
    assert wait_until(lambda: not is_dark(page))
    assert page.request.get(f"{panel[1]}/colours/another/dark").ok
    page.wait_for_timeout(1_000.0)
    assert not is_dark(page)
