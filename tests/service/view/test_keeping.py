"""*PNG*: what a browser gives instead of a picture ends in a sentence of the panel."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL.Image import DecompressionBombError

from tauten.model import Robot, skin_of
from tauten.service.describing import describe
from tauten.service.frames import RobotLook, TargetStore, ViewFrame
from tauten.service.setup import load_setup
from tauten.service.view import open_server
from tauten.service.view.keeping import SaveButtons
from tauten.service.view.program import WaypointProgram
from tauten.service.view.viewing import Viewing
from tauten.service.view.web import LoopbackServer


@pytest.fixture
def look(beam_file: Path, beam: Robot) -> RobotLook:
    vertices = skin_of(beam).geometry(beam, beam.rest(), None).vertices
    return RobotLook(describe(load_setup(beam_file)), vertices)


class Page:
    """A browser that gives one picture, or fails."""

    def __init__(self, outcome: Exception | None, window: tuple[int, int]) -> None:
        self.camera = SimpleNamespace(image_height=window[0], image_width=window[1])
        self.outcome, self.files = outcome, list[str]()
        self.asked: tuple[int, int] | None = None

    def get_render(self, height: int, width: int, **_settings: object) -> np.ndarray:
        self.asked = height, width
        if self.outcome is not None:
            raise self.outcome
        return np.full((height, width, 4), 255, np.uint8)

    def send_file_download(self, name: str, _content: bytes, **_settings: object) -> None:
        self.files.append(name)


def saved(look: RobotLook, *pages: Page) -> list[str]:
    """What the panel says after each page has been asked for a picture."""
    words = list[str]()
    frames: list[Any] = [SimpleNamespace(time=1.0)]
    shown: list[ViewFrame] = frames
    with open_server(0, "test") as (server, guard):
        viewing = Viewing(server, look, reaches=False)
        buttons = SaveButtons(server.gui, look, guard, lambda: shown, viewing, operated=True)
        for page in pages:
            event: Any = SimpleNamespace(client=page, target=SimpleNamespace(value="PNG"))
            buttons._save(event)
            words.append(buttons._words.content)
    return words


@pytest.mark.parametrize(
    "error",
    [
        OSError("image file is truncated"),
        ValueError("not a picture"),
        DecompressionBombError("20000 x 20000"),
        RuntimeError("no frame"),
        TimeoutError("no time"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_what_is_no_picture_is_said_in_the_panel(look: RobotLook, error: Exception) -> None:
    failing, working = Page(error, (90, 160)), Page(None, (90, 160))
    first, second = saved(look, failing, working)
    assert "not saved: the browser gave no picture" in first
    assert failing.files == []
    assert second == "", "the next one is saved"
    assert working.files == ["beam.png"]


@pytest.mark.parametrize(
    ("window", "asked"),
    [((90, 160), (90, 160)), ((3000, 6000), (1000, 2000)), ((1, 10**6), (1, 2000))],
)
def test_no_more_than_two_thousand_pixels_are_asked_for(
    look: RobotLook, window: tuple[int, int], asked: tuple[int, int]
) -> None:
    page = Page(OSError("not drawn"), window)
    saved(look, page)
    assert page.asked == asked


def test_waypoints_are_saved_by_the_browser_that_operates(
    look: RobotLook, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Browsers that looked on got the file, too."""
    operator, onlooker = Page(None, (90, 160)), Page(None, (90, 160))
    with open_server(0, "test") as (server, _):
        program = WaypointProgram(server, look, TargetStore(look.robot.effectors, look.robot.size))
        monkeypatch.setattr(LoopbackServer, "get_clients", lambda _: {3: operator, 4: onlooker})
        monkeypatch.setattr(LoopbackServer, "onlookers", {4: onlooker})
        program._save()
        monkeypatch.undo()
    assert (operator.files, onlooker.files) == (["waypoints.csv"], [])
