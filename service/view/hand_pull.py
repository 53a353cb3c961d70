"""Pulling a simulated robot by hand: a spring from an effector to the mouse."""

from __future__ import annotations

import numpy as np
import viser

from tauten.model.numerics import Array
from tauten.service.frames import RobotLook
from tauten.service.view.picture import Arrows

COLOUR = (200, 30, 130)


class HandPull:
    """What the mouse pulls, with the arrow of the force. Callbacks only note it; the loop reads it."""

    def __init__(
        self, scene: viser.SceneApi, look: RobotLook, skins: list[viser.MeshHandle]
    ) -> None:
        """Listen to drags of the skins with Ctrl."""
        self._scene, self._look = scene, look
        self._pull: tuple[Array, Array] | None = None  # grip and mouse (3,) [m]
        self._effector: int | None = None
        self._arrow = Arrows(scene, "/push", COLOUR, look.robot.size, (0.006, 0.014, 0.03))
        self._number: viser.LabelHandle | None = None
        for skin in skins:
            skin.on_drag("left", modifier="cmd/ctrl")(self._dragged)

    def release(self) -> None:
        """Let go: the browser has left."""
        self._pull = None

    def taken(self, positions: Array) -> tuple[int, Array] | None:
        """Number of the effector that is pulled now, and where the mouse holds it (3,) [m]; None: none is.

        Effectors have positions (p, 3) [m], NaN for those without.
        """
        pull = self._pull
        if pull is None or not np.isfinite(positions).any():
            self._effector = None
            return None
        grip, end = pull
        if self._effector is None:  # stays the same until the mouse lets go
            self._effector = int(np.nanargmin(np.linalg.norm(positions - grip, axis=1)))
        return self._effector, positions[self._effector] + (end - grip)

    def show(self, position: Array | None, force: Array | None) -> None:
        """Show a force (3,) on an effector [N] at its position (3,) [m], with its number; None: none."""
        if position is None or force is None:
            self._arrow.draw(np.zeros((0, 2, 3), np.float32))
            if self._number is not None:
                self._number.visible = False
            return
        strength = float(np.linalg.norm(force))
        tip = position + 0.2 * self._look.robot.size * force / max(strength, 1e-12)
        self._arrow.draw(np.stack([position, tip])[None].astype(np.float32))
        if self._number is None:
            self._number = self._scene.add_label("/push_number", "")
        self._number.position, self._number.text = tip, f"{strength:.2g} N"
        self._number.visible = True

    async def _dragged(self, event: viser.SceneNodeDragEvent[viser.MeshHandle]) -> None:
        if event.phase == "end":
            self._pull = None
            return
        self._pull = np.array(event.start_position), np.array(event.end_position)
