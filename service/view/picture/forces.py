"""Forces with their numbers: of actuators as arrows, and of the largest contact forces.

Contacts with friction have their cone too, which opens to where the arrow of the force begins, and the number
says how much more friction until they slide.
"""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from tauten.model import Floats, PushingContacts
from tauten.model.numerics import Array
from tauten.service.frames import RobotLook, ViewFrame
from tauten.service.view.picture.actuators import LINES, TIGHT, effort_share
from tauten.service.view.picture.arrows import Arrows
from tauten.service.view.picture.cameras import Camera, camera_of, upwards

_MOST = 6  # contact forces with a number
_APART = 0.12  # between them, as a share of the robot's size: numbers do not cover each other
_LINE, _WIDTH = 0.035, 0.14  # of a number in the picture, as shares of the robot's size
_LENGTH = 0.25  # of the arrow of an effort at its limit, as a share of the robot's size
# height of a cone as a share of the robot's size; largest width
_CONE, _SIDES, _WIDEST = 0.12, 16, 3.0
_NO_MARGIN = 1e-3  # of a force, distance to slip that is none
_CONE_COLOUR = (120, 120, 130)
# share of the limit below which a cable has no arrow: numbers of slack ones would cover each other
_LEAST = 0.02


class ForceNumbers:
    """Arrows and labels, which are only there while they are wanted."""

    def __init__(self, scene: viser.SceneApi, look: RobotLook) -> None:
        self._scene, self._look = scene, look
        self._labels: dict[str, viser.LabelHandle] = {}
        self._arrows = Arrows(scene, "/efforts", TIGHT, look.robot.size, (0.005, 0.012, 0.025))
        self._cones: viser.MeshHandle | None = None
        self._first, self._up = camera_of(look, "fit"), np.array(upwards(look.robot.gravity))

    def draw(self, frame: ViewFrame | None) -> None:
        """Show the forces of a frame; None: none are shown."""
        texts: dict[str, tuple[str, Array]] = {}
        arrows: list[Array] = []
        if frame is not None:
            texts, arrows = self._of_actuators(frame)
            numbered = self._largest_contacts(frame.geometry.contacts)
            texts |= contact_numbers(frame.geometry.contacts, numbered)
            texts = self._uncovered(texts)
            self._draw_cones(frame.geometry.contacts, numbered)
        elif self._cones is not None:
            self._cones.visible = False
        for name in self._labels.keys() - texts.keys():
            self._labels.pop(name).remove()
        for name, (text, position) in texts.items():
            label = self._labels.get(name)
            if label is None:
                self._labels[name] = self._scene.add_label(name, text, position=position)
                continue
            label.position, label.text = position, text
        self._arrows.draw(np.array(arrows, np.float32))

    def _uncovered(self, texts: dict[str, tuple[str, Array]]) -> dict[str, tuple[str, Array]]:
        """The same texts, in places where none covers another in the first view."""
        if not texts:
            return texts
        places = np.array([place for _, place in texts.values()])
        raised = stacked(places, self._first, self._up, self._look.robot.size)
        return {
            name: (text, place)
            for (name, (text, _)), place in zip(texts.items(), raised, strict=True)
        }

    def _of_actuators(self, frame: ViewFrame) -> tuple[dict[str, tuple[str, Array]], list[Array]]:
        """Numbers at the first point of each actuator, where it does something; arrows along cables."""
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
            if one.kind in LINES:
                share = effort_share(one, effort)
                if share <= _LEAST:
                    continue
                along = start - pieces[0, 1]
                along *= (
                    _LENGTH * share * look.robot.size / max(float(np.linalg.norm(along)), 1e-12)
                )
                arrows.append(np.stack([start, start + along]))
                start = start + along
            texts[f"/numbers/{one.name}"] = text, start
        return texts, arrows

    def _largest_contacts(self, contacts: PushingContacts) -> list[int]:
        """Numbers of the largest contact forces that are apart from each other."""
        apart, chosen = _APART * self._look.robot.size, list[int]()
        for i in np.argsort(-np.linalg.norm(contacts.forces, axis=1)).tolist():
            away = np.linalg.norm(contacts.points[chosen] - contacts.points[i], axis=1)
            if (away > apart).all():
                chosen.append(i)
            if len(chosen) == _MOST:
                break
        return chosen

    def _draw_cones(self, contacts: PushingContacts, chosen: list[int]) -> None:
        """Cones of friction of some contacts; they take as many vertices whatever their number."""
        rubbing = [i for i in chosen if contacts.friction[i] > 0.0]
        if not rubbing:
            if self._cones is not None:
                self._cones.visible = False
            return
        vertices, triangles = friction_cones(contacts, rubbing, _CONE * self._look.robot.size)
        if self._cones is None:
            self._cones = self._scene.add_mesh_simple(
                "/cones", vertices, triangles, color=_CONE_COLOUR, wireframe=True, cast_shadow=False,
                receive_shadow=False,
            )  # fmt: skip
        self._cones.vertices, self._cones.visible = vertices, True


def stacked(places: Array, camera: Camera, up: Array, size: float) -> Array:
    """Places of labels (m, 3) [m], raised in the picture as far as each needs not to cover one below it.

    Args:
        places: (m, 3) where they would be [m].
        camera: that looks at them.
        up: (3,) direction that points up in the picture.
        size: of the robot [m].
    """
    out = camera.position - camera.look_at
    distance = float(np.linalg.norm(out))
    out = out / distance
    x = np.cross(up, out)
    x /= np.linalg.norm(x)
    y = np.cross(out, x)
    nearer = (camera.position - places) @ out / distance  # (m,) by which lengths there look larger
    seen = (places - camera.look_at) @ np.stack([x, y], axis=1) / nearer[:, None]  # (m, 2)
    raised, done = seen.copy(), list[int]()
    for i in np.argsort(seen[:, 1], kind="stable").tolist():
        while True:
            across, height = (raised[i] - raised[done]).T
            covers = (np.abs(height) < _LINE * size) & (np.abs(across) < _WIDTH * size)
            if not covers.any():
                break
            raised[i, 1] += 1.01 * _LINE * size - height[covers].min()
        done.append(i)
    found: Array = places + ((raised - seen)[:, 1] * nearer)[:, None] * y
    return found


def contact_numbers(contacts: PushingContacts, chosen: list[int]) -> dict[str, tuple[str, Array]]:
    """Text and place of contact forces by the name of their label."""
    texts = {}
    for place, i in enumerate(chosen):
        size, margin = float(np.linalg.norm(contacts.forces[i])), float(contacts.margin[i])
        text = f"{size:.2g} N"
        if contacts.friction[i] > 0.0:
            left = f"{margin:.2g} N to slip" if margin > _NO_MARGIN * size else "about to slip"
            text += ", slides" if contacts.sliding[i] else f", {left}"
        texts[f"/contact_numbers/{place}"] = text, contacts.points[i].astype(float)
    return texts


def friction_cones(
    contacts: PushingContacts, chosen: list[int], height: float
) -> tuple[Floats, NDArray[np.uint32]]:
    """Cones of friction: vertices (6 (1 + sides), 3) [m] and triangles (6 sides, 3).

    Their tips are the contact points, and they open against the normals, to where arrows of forces begin.

    Args:
        contacts: that push.
        chosen: those with a cone, at most six.
        height: [m].
    """
    turn = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    vertices = np.repeat(contacts.points[chosen[0]][None], _MOST * (1 + _SIDES), axis=0)
    for place, i in enumerate(chosen):
        across = np.linalg.svd(contacts.normals[i][None])[2][1:]  # (2, 3)
        rim = np.stack([np.cos(turn), np.sin(turn)], axis=1) @ across  # (_SIDES, 3)
        width = height * min(float(contacts.friction[i]), _WIDEST)
        first = place * (1 + _SIDES)
        vertices[first] = contacts.points[i]
        around = contacts.points[i] - height * contacts.normals[i] + width * rim
        vertices[first + 1 : first + 1 + _SIDES] = around
    here = np.arange(_SIDES)
    one = np.stack([np.zeros_like(here), 1 + here, 1 + (here + 1) % _SIDES], axis=1)
    every = one[None] + ((1 + _SIDES) * np.arange(_MOST))[:, None, None]
    return vertices.astype(np.float32), every.reshape(-1, 3).astype(np.uint32)
