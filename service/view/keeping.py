"""Buttons that save what is shown: a PNG of the picture, and the last seconds as a film."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

import viser
from PIL.Image import DecompressionBombError

from tauten.service.frames import RobotLook, ViewFrame
from tauten.service.view.export import film, picture
from tauten.service.view.viewing import Viewing
from tauten.service.view.web import Guard
from tauten.service.view.words import Words

log = logging.getLogger(__name__)

FILM = 30.0  # s of a film at most
_PNG, _FILM = "PNG", "film"
_PATIENCE = 30.0  # s for the picture of a browser
_LARGEST = 2000  # pixels of its larger side
_NO_PICTURE = "not saved: the browser gave no picture of the size that was asked for; try again"


class SaveButtons:
    """The buttons of the operator. They work in a thread of their own: the robot goes on."""

    def __init__(
        self,
        gui: viser.GuiApi,
        look: RobotLook,
        guard: Guard,
        frames: Callable[[], list[ViewFrame]],
        viewing: Viewing,
        operated: bool,
    ) -> None:
        self._operated = operated
        self._look, self._guard, self._frames = look, guard, frames
        self._viewing = viewing
        self._busy = threading.Lock()
        buttons = gui.add_button_group(
            "save",
            (_PNG, _FILM),
            hint=f"film: the last {FILM:.0f} s as a page that plays by itself.",
        )
        self._words = gui.add_html("")
        buttons.on_click(self._save)

    def _save(self, event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
        frames, client = self._frames(), event.client
        if client is None or not frames or not self._busy.acquire(blocking=False):
            return
        self._words.content = ""
        try:
            name = self._look.robot.name
            if event.target.value == _FILM:
                content = film(self._look, frames)[0].encode()
                client.send_file_download(f"{name}.html", content, save_immediately=True)
                return
            content = self._photograph(client, frames[-1].time)
            client.send_file_download(f"{name}.png", content, save_immediately=True)
        except (OSError, RuntimeError, ValueError, DecompressionBombError) as error:
            # the browser has left, has no time, or has sent something else
            log.warning("the browser gave no picture: %s", error)
            self._words.content = Words(advice=_NO_PICTURE).html
        finally:
            self._busy.release()

    def _photograph(self, client: viser.ClientHandle, time: float) -> bytes:
        camera = client.camera
        scale = min(1.0, _LARGEST / max(camera.image_height, camera.image_width, 1))
        height, width = (
            max(round(scale * side), 1) for side in (camera.image_height, camera.image_width)
        )
        with self._guard.picture(height, width):  # it passes this size alone
            image = client.get_render(height, width, transport_format="png", timeout=_PATIENCE)
        return picture(image, self._look, time, self._viewing.strain, self._operated)
