"""Forces with their numbers: of actuators as arrows, and of the largest contact forces."""

from __future__ import annotations

import numpy as np
import viser

from tauten.model.numerics import Array
from tauten.service.frames import RobotLook, ViewFrame
from tauten.service.view.picture.actuators import LINES, TIGHT, effort_share

_MOST = 6  # contact forces with a number
_APART = 0.12  # between them, as a share of the robot's size: numbers do not cover each other
_LENGTH = 0.25  # of the arrow of an effort at its limit, as a share of the robot's size
_LEAST = 0.02  # share of the limit below which no arrow is drawn


class ForceNumbers:
    """Arrows and labels, which are only there while they are wanted."""

    def __init__(self, scene: viser.SceneApi, look: RobotLook) -> None:
        """Add nothing yet.

        Args:
            scene: that shows them.
            look: of the robot.
        """
        self._scene, self._look = scene, look
        self._labels: dict[str, viser.LabelHandle] = {}
        self._arrows: viser.ArrowsHandle | None = None

    def draw(self, frame: ViewFrame | None) -> None:
        """Show the forces of a frame; None: none are shown.

        Args:
            frame: to show.
        """
        texts: dict[str, tuple[str, Array]] = {}
        arrows: list[Array] = []
        if frame is not None:
            texts, arrows = self._of_actuators(frame)
            texts |= self._of_contacts(frame)
        for name in self._labels.keys() - texts.keys():
            self._labels.pop(name).remove()
        for name, (text, position) in texts.items():
            label = self._labels.get(name)
            if label is None:
                self._labels[name] = self._scene.add_label(name, text, position=position)
                continue
            label.position = position
            if label.text != text:
                label.text = text
        self._draw_arrows(arrows)

    def _draw_arrows(self, arrows: list[Array]) -> None:
        if self._arrows is not None and (
            len(arrows) == 0 or len(arrows) != len(self._arrows.points)
        ):
            self._arrows.remove()
            self._arrows = None
        if not arrows:
            return
        points, size = np.array(arrows, np.float32), self._look.robot.size
        if self._arrows is not None:
            self._arrows.points = points
            return
        self._arrows = self._scene.add_arrows(
            "/efforts", points, TIGHT, shaft_radius=0.005 * size, head_radius=0.012 * size,
            head_length=0.025 * size,
        )  # fmt: skip

    def _of_actuators(self, frame: ViewFrame) -> tuple[dict[str, tuple[str, Array]], list[Array]]:
        """Numbers at the first point of each actuator; arrows along cables, out of the robot."""
        texts, arrows = {}, []
        look, geometry = self._look, frame.geometry
        surface = look.robot.surface
        for i, one in enumerate(look.robot.actuators):
            effort = float(frame.effort[i])
            pieces = geometry.segments[surface.segments == i].astype(float)
            text = f"{one.name} {one.kind.effort.text(effort)}"
            if len(pieces) == 0:
                inside = surface.triangles[surface.chambers == i]
                if len(inside):
                    middle = geometry.vertices[np.unique(inside)].mean(axis=0).astype(float)
                    texts[f"/numbers/{one.name}"] = text, middle
                continue
            start = pieces[0, 0]
            share = effort_share(one, effort)
            if one.kind in LINES and share > _LEAST:
                along = start - pieces[0, 1]
                along *= (
                    _LENGTH * share * look.robot.size / max(float(np.linalg.norm(along)), 1e-12)
                )
                arrows.append(np.stack([start, start + along]))
                start = start + along
            texts[f"/numbers/{one.name}"] = text, start
        return texts, arrows

    def _of_contacts(self, frame: ViewFrame) -> dict[str, tuple[str, Array]]:
        contacts = frame.geometry.contacts
        lam = np.linalg.norm(contacts.forces, axis=1)
        apart, chosen = _APART * self._look.robot.size, list[Array]()
        texts: dict[str, tuple[str, Array]] = {}
        for i in np.argsort(-lam).tolist():
            point = contacts.points[i].astype(float)
            if all(float(np.linalg.norm(point - one)) > apart for one in chosen):
                texts[f"/contact_numbers/{len(chosen)}"] = f"{lam[i]:.2g} N", point
                chosen.append(point)
            if len(chosen) == _MOST:
                break
        return texts
