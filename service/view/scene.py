"""The picture: skin, cables by tension, contact forces, targets and effectors with their trails."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from tauten.model import Contacts, Floats
from tauten.model.numerics import Array
from tauten.service.frames import ActuatorLook, RobotLook, ViewFrame

_SILICONE = (140, 160, 185)
_SLACK, _MIDDLE, _TIGHT = (
    (30, 80, 200),
    (235, 170, 20),
    (215, 20, 20),
)  # cables from slack to the limit
_THIN, _THICK = 0.010, 0.024  # thickness of a cable, as a share of the robot's size
_TARGET, _EFFECTOR, _CONTACT, _WAYPOINT = (
    (215, 60, 40),
    (40, 90, 160),
    (0, 140, 70),
    (120, 60, 160),
)
_ARROW = 0.15  # length of the arrow of the largest force, as a share of the robot's size
TRAIL = 4.0  # s
_TRAIL = 120  # pieces of a trail
_STEPS = 16  # levels of a cable's colour: nothing is sent while the level remains


class RobotScene:
    """Draws frames of one robot into a server's scene."""

    def __init__(self, server: viser.ViserServer, look: RobotLook, draggable: bool) -> None:
        """Add all objects at rest.

        Args:
            server: whose scene is used.
            look: of the robot.
            draggable: whether targets are gizmos rather than points.
        """
        self._look, self._scene = look, server.scene
        size = look.size
        self._largest = 0.0  # contact force so far [N]
        self._levels = [-1] * len(look.actuators)
        scene = server.scene
        scene.set_up_direction("+z")
        _place_camera(server, look)
        self._skin = scene.add_mesh_simple(
            "/skin", look.vertices, look.triangles.astype(np.uint32), color=_SILICONE, opacity=0.5,
            side="double", flat_shading=True, cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        self._cables = [
            scene.add_line_segments(
                f"/cables/{actuator.name}",
                np.zeros((int((look.cable_owners == i).sum()), 2, 3), np.float32),
                _SLACK,
                thickness=_THIN * size,
            )
            for i, actuator in enumerate(look.actuators)
            if (look.cable_owners == i).any()
        ]
        self._cable_numbers = [
            i for i in range(len(look.actuators)) if (look.cable_owners == i).any()
        ]
        self._arrows: viser.ArrowsHandle | None = None
        self._effectors = [
            scene.add_icosphere(f"/effectors/{name}", 0.012 * size, _EFFECTOR, subdivisions=2)
            for name in look.effectors
        ]
        self._targets = [
            scene.add_icosphere(f"/targets/{name}", 0.012 * size, _TARGET, subdivisions=2)
            for name in look.effectors
        ]
        self.gizmos = [
            scene.add_transform_controls(
                f"/gizmos/{name}", 0.25 * size, disable_rotations=True, depth_test=False,
                position=look.rest[i],
            )
            for i, name in enumerate(look.effectors)
            if draggable
        ]  # fmt: skip
        count = len(look.effectors)
        self._trails = [
            _Trail(server, f"/trails/{kind}/{look.effectors[i]}", colour, 0.0025 * size)
            for kind, colour in (("target", _TARGET), ("effector", _EFFECTOR))
            for i in range(count)
        ]
        self._dragged: list[bool] = [False] * count

    def draw(self, frame: ViewFrame, trail: list[ViewFrame]) -> None:
        """Show a frame.

        Args:
            frame: to show.
            trail: frames before it, for the trails.
        """
        geometry = frame.geometry
        self._skin.vertices = geometry.vertices
        self._draw_cables(geometry.cables, frame.tension)
        self._draw_contacts(geometry.contacts)
        for i, position in enumerate(frame.effector):
            self._effectors[i].position = position
            target = frame.target[i]
            seen = bool(np.isfinite(target).all())
            if self._targets[i].visible != seen:
                self._targets[i].visible = seen
            if seen:
                self._targets[i].position = target
        count = len(frame.effector)
        step = max(len(trail) // _TRAIL, 1)
        for i in range(count):
            self._trails[i].draw([one.target[i] for one in trail[::step]])
            self._trails[count + i].draw([one.effector[i] for one in trail[::step]])

    def place_gizmos(self, positions: Array) -> None:
        """Move gizmos that are not where they belong to positions (p, 3) [m]."""
        for gizmo, position in zip(self.gizmos, positions, strict=True):
            if float(np.abs(gizmo.position - position).max()) > 1e-4 * self._look.size:
                gizmo.position = position

    def on_drag(self, moved: Callable[[int, Array], None]) -> None:
        """Call a function with the effector's number and a position (3,) [m] when a gizmo is dragged."""
        for i, gizmo in enumerate(self.gizmos):
            gizmo.on_update(_mover(i, moved))

    def show_waypoints(self, points: Array) -> None:
        """Show waypoints (m, 3) [m] instead of those shown before."""
        self._scene.remove_by_name("/waypoints")
        if len(points):
            self._scene.add_point_cloud(
                "/waypoints", points.astype(np.float32), _WAYPOINT, point_size=0.025 * self._look.size,
                point_shape="circle", precision="float32",
            )  # fmt: skip

    def _draw_cables(self, ends: Floats, tension: Array) -> None:
        owners, size = self._look.cable_owners, self._look.size
        for handle, i in zip(self._cables, self._cable_numbers, strict=True):
            handle.points = ends[owners == i]
            share = tension_share(self._look.actuators[i], float(tension[i]))
            level = round(share * _STEPS)
            if level != self._levels[i]:
                self._levels[i] = level
                pieces = len(handle.points)
                handle.colors = np.tile(
                    np.array(cable_colour(level / _STEPS), np.uint8), (pieces, 2, 1)
                )
                handle.thickness = size * (_THIN + (_THICK - _THIN) * level / _STEPS)

    def _draw_contacts(self, contacts: Contacts) -> None:
        """Arrows whose tips touch the contact points: forces push there."""
        if len(contacts.points) == 0:
            if self._arrows is not None:
                self._arrows.visible = False
            return
        size = self._look.size
        lengths = np.linalg.norm(contacts.forces, axis=1)
        self._largest = max(self._largest, float(lengths.max()))
        drawn = contacts.forces * (_ARROW * size / self._largest)
        points = np.stack([contacts.points - drawn, contacts.points], axis=1).astype(np.float32)
        if self._arrows is None:
            self._arrows = self._scene.add_arrows(
                "/contacts", points, _CONTACT, shaft_radius=0.004 * size, head_radius=0.009 * size,
                head_length=0.02 * size,
            )  # fmt: skip
            return
        self._arrows.points = points
        if not self._arrows.visible:
            self._arrows.visible = True


class _Trail:
    """A line through the last positions, of a fixed number of pieces."""

    def __init__(
        self, server: viser.ViserServer, name: str, colour: tuple[int, int, int], thickness: float
    ) -> None:
        self._handle = server.scene.add_line_segments(
            name, np.zeros((_TRAIL, 2, 3), np.float32), colour, thickness=thickness, visible=False
        )

    def draw(self, positions: list[Array]) -> None:
        """Show a line through positions (3,) [m]; pieces to positions that are not finite are left out."""
        pieces = line_pieces(np.array(positions).reshape(-1, 3))
        if pieces is None:
            if self._handle.visible:
                self._handle.visible = False
            return
        self._handle.points = pieces
        if not self._handle.visible:
            self._handle.visible = True


def line_pieces(points: Array) -> Floats | None:
    """Pieces (_TRAIL, 2, 3) of a line through positions (m, 3); None without any."""
    pairs = np.stack([points[:-1], points[1:]], axis=1)  # (m - 1, 2, 3)
    found = pairs[np.isfinite(pairs).all(axis=(1, 2))][-_TRAIL:]
    if len(found) == 0:
        return None
    pieces = np.repeat(found[-1:, 1:], _TRAIL * 2, axis=0).reshape(_TRAIL, 2, 3)
    pieces[: len(found)] = found
    return pieces.astype(np.float32)


def tension_share(actuator: ActuatorLook, tension: float) -> float:
    """Tension as a share of its limit, 0 … 1; of a pressure that may be negative, of the farther limit."""
    limit = max(abs(actuator.tension[0]), abs(actuator.tension[1]))
    return min(abs(tension) / limit, 1.0) if limit > 0.0 and np.isfinite(tension) else 0.0


def cable_colour(share: float) -> tuple[int, int, int]:
    """Colour of a cable at a share 0 … 1 of its largest tension."""
    first, second = (_SLACK, _MIDDLE) if share < 0.5 else (_MIDDLE, _TIGHT)
    t = 2.0 * share if share < 0.5 else 2.0 * share - 1.0
    r, g, b = (round(a + t * (c - a)) for a, c in zip(first, second, strict=True))
    return r, g, b


def _mover(
    number: int, moved: Callable[[int, Array], None]
) -> Callable[[viser.TransformControlsEvent], Coroutine[Any, Any, None]]:
    async def callback(event: viser.TransformControlsEvent) -> None:
        moved(number, np.array(event.target.position))

    return callback


def _place_camera(server: viser.ViserServer, look: RobotLook) -> None:
    """Look at the middle of the robot from the front, with a near plane that does not cut small robots."""
    low, high = look.vertices.min(axis=0), look.vertices.max(axis=0)
    middle: NDArray[np.float64] = 0.5 * (low + high).astype(float)
    camera = server.initial_camera
    camera.position = tuple(middle + look.size * np.array([0.35, -1.25, 0.25]))
    camera.look_at = tuple(middle)
    camera.near, camera.far = 0.02 * look.size, 100.0 * look.size
