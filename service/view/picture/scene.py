"""The picture: skin, actuators, contact forces, targets and effectors with their trails."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Any

import numpy as np
import viser

from tauten.model import Floats, PushingContacts
from tauten.model.numerics import Array
from tauten.service.frames import RobotLook, ViewFrame
from tauten.service.view.picture.actuators import drawings_of
from tauten.service.view.picture.arrows import Arrows
from tauten.service.view.picture.cameras import place_first, upwards
from tauten.service.view.picture.surroundings import draw_surroundings
from tauten.service.wire import places_of

_SILICONE = (140, 160, 185)
OBJECT = (170, 135, 200)
TARGET = (215, 60, 40)
EFFECTOR = (40, 90, 160)
CONTACT = (0, 140, 70)
SLIDES = (235, 105, 0)
WAYPOINT = (120, 60, 160)
GHOST = (240, 150, 40)
_ARROW = 0.15  # length of the arrow of the largest force, as a share of the robot's size
TRAIL = 4.0  # s
_TRAIL = 120  # pieces of a trail
_NUMBERED = 20  # waypoints at most that have their number beside them


class RobotScene:
    """Draws frames of one robot into a server's scene.

    Attributes:
        skins: of the robot, and of its objects where it has some.
        gizmos: of the targets that can be dragged, by the number of the effector.
    """

    def __init__(self, server: viser.ViserServer, look: RobotLook, draggable: bool) -> None:
        """Add all objects at rest."""
        self._look, self._scene = look, server.scene
        robot, skin = look.robot, look.robot.surface
        size = robot.size
        self._largest = 0.0  # contact force so far [N]
        scene = server.scene
        scene.set_up_direction(upwards(robot.gravity))
        self._obstacles = draw_surroundings(server, look)
        place_first(server, look)
        outer, passive = skin.chambers < 0, np.isin(np.arange(len(skin.triangles)), skin.objects)
        self.skins = [
            scene.add_mesh_simple(
                name, look.vertices, skin.triangles[outer & own].astype(np.uint32), color=colour,
                opacity=0.5, side="double", flat_shading=True, cast_shadow=False, receive_shadow=False,
            )
            for name, colour, own in (("/skin", _SILICONE, ~passive), ("/objects", OBJECT, passive))
            if own.any()
        ]  # fmt: skip
        self._ghost = None
        if look.ghost is not None:
            self._ghost = scene.add_mesh_simple(
                "/ghost", np.zeros((int(look.ghost.max()) + 1, 3), np.float32),
                look.ghost.astype(np.uint32), color=GHOST, wireframe=True, cast_shadow=False,
                receive_shadow=False, visible=False,
            )  # fmt: skip
        self._drawings = drawings_of(scene, look)
        self._arrows = [
            Arrows(scene, name, colour, size, (0.004, 0.009, 0.02))
            for name, colour in (("/contacts", CONTACT), ("/contacts_that_slide", SLIDES))
        ]
        self._effectors = [
            scene.add_icosphere(f"/effectors/{one.name}", 0.012 * size, EFFECTOR, subdivisions=2)
            for one in robot.effectors
        ]
        self._targets = [
            scene.add_icosphere(f"/targets/{one.name}", 0.012 * size, TARGET, subdivisions=2)
            for one in robot.effectors
        ]
        self.gizmos = {
            i: scene.add_transform_controls(
                f"/gizmos/{one.name}", 0.25 * size, disable_rotations=not one.turns,
                depth_test=False, position=np.array(one.rest[:3]),
            )
            for i, one in enumerate(robot.effectors)
            if draggable and one.has_position
        }  # fmt: skip
        self._trails = [
            scene.add_line_segments(
                f"/trails/{kind}/{one.name}", np.zeros((_TRAIL, 2, 3), np.float32), colour,
                thickness=0.0025 * size, visible=False,
            )
            for kind, colour in (("target", TARGET), ("effector", EFFECTOR))
            for one in robot.effectors
        ]  # fmt: skip

    def draw(self, frame: ViewFrame, trail: list[ViewFrame]) -> None:
        """Show a frame."""
        geometry = frame.geometry
        for skin in self.skins:
            skin.vertices = geometry.vertices
        for i, draw in self._drawings:
            own = geometry.segments[self._look.robot.surface.segments == i]
            draw(geometry.vertices, own, float(frame.position[i]), float(frame.effort[i]))
        if self._ghost is not None and self._ghost.visible and frame.ghost is not None:
            self._ghost.vertices = frame.ghost
        self._draw_contacts(geometry.contacts)
        look = self._look
        for mesh, one in zip(self._obstacles, look.robot.surface.obstacles, strict=True):
            pose = frame.obstacles.get(one.name)
            if pose is not None:
                mesh.position, mesh.wxyz = pose.position, pose.quaternion
        places = (
            (self._effectors, look.positions(frame.values)),
            (self._targets, look.targets(frame)),
        )
        for shown, positions in places:
            for sphere, position in zip(shown, positions, strict=True):
                _show_at(sphere, position)
        trail = trail[:: max(len(trail) // _TRAIL, 1)]
        targets, effectors = look.trails(trail)  # (m, p, 3)
        count = len(look.robot.effectors)
        for i in range(count):
            _show_trail(self._trails[i], targets[:, i])
            _show_trail(self._trails[count + i], effectors[:, i])

    def show_skin(self, shown: bool) -> None:
        """Show or hide the skins in one colour each."""
        for skin in self.skins:
            skin.visible = shown

    def show_ghost(self, shown: bool) -> None:
        """Show or hide the model beside the robot."""
        if self._ghost is not None:
            self._ghost.visible = shown

    def place_gizmos(self, values: Array) -> None:
        """Move gizmos that are not where goal values (n_v,) say."""
        places = places_of(self._look.robot.effectors)
        for i, gizmo in self.gizmos.items():
            one = self._look.robot.effectors[i]
            own = values[places[i]]
            if float(np.abs(gizmo.position - own[:3]).max()) > 1e-4 * self._look.robot.size:
                gizmo.position = own[:3]
            if one.turns and float(np.abs(gizmo.wxyz - own[3:]).max()) > 1e-4:
                gizmo.wxyz = own[3:]

    def show_gizmos(self, shown: bool) -> None:
        """Show gizmos, or hide them while the past is shown."""
        for gizmo in self.gizmos.values():
            gizmo.visible = shown

    def on_drag(self, moved: Callable[[int, Array], None]) -> None:
        """Call a function with the effector's number and goal values (v,) when a gizmo is dragged."""
        for i, gizmo in self.gizmos.items():
            gizmo.on_update(_mover(i, self._look.robot.effectors[i].turns, moved))

    def show_waypoints(self, points: Array) -> None:
        """Show waypoints (m, 3) [m] instead of those shown before."""
        self._scene.remove_by_name("/waypoints")
        self._scene.remove_by_name("/program")
        if len(points) > 1:
            self._scene.add_line_segments(
                "/program", np.stack([points[:-1], points[1:]], axis=1).astype(np.float32), WAYPOINT,
                thickness=0.003 * self._look.robot.size,
            )  # fmt: skip
        for i, point in enumerate(points[:_NUMBERED], 1):
            self._scene.add_label(f"/program/{i}", str(i), position=point, anchor="bottom-left")
        if len(points):
            self._scene.add_point_cloud(
                "/waypoints", points.astype(np.float32), WAYPOINT, point_size=0.025 * self._look.robot.size,
                point_shape="circle", precision="float32",
            )  # fmt: skip

    def _draw_contacts(self, contacts: PushingContacts) -> None:
        """Arrows whose tips touch the contact points: forces push there."""
        size = self._look.robot.size
        lengths = np.linalg.norm(contacts.forces, axis=1)
        self._largest = max(self._largest, float(lengths.max(initial=1e-30)))
        drawn = contacts.forces * (_ARROW * size / self._largest)
        points = np.stack([contacts.points - drawn, contacts.points], axis=1).astype(np.float32)
        slides = contacts.sliding & (contacts.friction > 0.0)
        for arrows, chosen in zip(self._arrows, (~slides, slides), strict=True):
            arrows.draw(points[chosen])


def _show_trail(line: viser.LineSegmentsHandle, positions: Array) -> None:
    """Show a line through positions (m, 3) [m]; pieces to those that are not finite are left out."""
    pieces = line_pieces(positions)
    line.visible = pieces is not None
    if pieces is not None:
        line.points = pieces


def line_pieces(points: Array) -> Floats | None:
    """Pieces (_TRAIL, 2, 3) of a line through positions (m, 3); None without any."""
    pairs = np.stack([points[:-1], points[1:]], axis=1)  # (m - 1, 2, 3)
    found = pairs[np.isfinite(pairs).all(axis=(1, 2))][-_TRAIL:]
    if len(found) == 0:
        return None
    pieces = np.repeat(found[-1:, 1:], _TRAIL * 2, axis=0).reshape(_TRAIL, 2, 3)
    pieces[: len(found)] = found
    return pieces.astype(np.float32)


def _show_at(sphere: viser.IcosphereHandle, position: Array) -> None:
    """Show a sphere at a position (3,) [m]; nowhere where it is not finite."""
    seen = bool(np.isfinite(position).all())
    sphere.visible = seen
    if seen:
        sphere.position = position


def _mover(
    number: int, turns: bool, moved: Callable[[int, Array], None]
) -> Callable[[viser.TransformControlsEvent], Coroutine[Any, Any, None]]:
    async def callback(event: viser.TransformControlsEvent) -> None:
        position, rotation = event.target.position, event.target.wxyz
        moved(number, np.concatenate([position, rotation]) if turns else np.array(position))

    return callback
