"""How actuators are drawn: cables with their springs, chambers, forces, drives and slides.

A drawing is made once for each actuator and updated with each frame; viser sends what has changed.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import viser

from tauten.model import ActuatorKind, Floats
from tauten.model.contact import across
from tauten.model.numerics import Array, Ints
from tauten.service.frames import RobotLook
from tauten.service.view.picture.arrows import Arrows
from tauten.service.wire import DescribedActuator

Colour = tuple[int, int, int]
SLACK, MIDDLE, TIGHT = (30, 80, 200), (235, 170, 20), (215, 20, 20)  # effort from none to its limit
VACUUM, NO_PRESSURE, PRESSURE = (40, 90, 220), (225, 225, 225), (215, 20, 20)
FORCE, AXIS, SPRING = (200, 30, 130), (90, 60, 30), (60, 60, 60)
# Kinds that are drawn as lines between their points.
LINES = (
    ActuatorKind.CABLE, ActuatorKind.TRANSMISSION, ActuatorKind.ROTARY_TRANSMISSION,
    ActuatorKind.FLUID_TRANSMISSION,
)  # fmt: skip
LEVELS = 16  # of a colour: nothing is sent while the level remains
_SLENDER = 0.15  # largest width that is counted, as a share of the robot's size
_THIN, _THICK = 0.06, 0.15  # thickness of a cable, as a share of the robot's width
_ARROW = 0.2  # length of the arrow of the largest force, as a share of the robot's size
_LEAST = 0.01  # share of that force below which no arrow is drawn
_RADIUS = 0.12  # of the arc of a drive, as a share of the robot's size
_ARC = 24  # pieces of the arc of an angle
_COILS = 6
_SPRING = 0.06  # length of a spring without force, as a share of the robot's size


# Shows an actuator by the vertices (P, 3) of the skin [m], its own segments (s, 2, 3) [m], see
# `Robot.actuator_segments`, its position and its effort [SI].
Drawing = Callable[[Floats, Floats, float, float], None]


def drawings_of(scene: viser.SceneApi, look: RobotLook) -> list[tuple[int, Drawing]]:
    """Drawings of the actuators, each with the number of its actuator."""
    found: list[tuple[int, Drawing]] = []
    surface = look.robot.surface
    for i, actuator in enumerate(look.robot.actuators):
        count = int((surface.segments == i).sum())
        triangles = surface.triangles[surface.chambers == i]
        if len(triangles):
            found.append((i, _chamber(scene, look, actuator, triangles)))
        if count == 0:
            continue
        if actuator.kind in LINES:
            found.append((i, _cable(scene, look, actuator, count)))
            if actuator.flexibility > 0.0:
                found.append((i, _spring(scene, look, actuator)))
        elif actuator.kind is ActuatorKind.FORCE:
            found.append((i, _force(scene, look, actuator)))
        else:
            found.append((i, _drive(scene, look, actuator, count)))
    return found


def _cable(
    scene: viser.SceneApi, look: RobotLook, actuator: DescribedActuator, count: int
) -> Drawing:
    """A line, from blue and thin to red and thick."""
    width = width_of(look)
    line = scene.add_line_segments(
        f"/actuators/{actuator.name}", np.zeros((count, 2, 3), np.float32), SLACK,
        thickness=_THIN * width,
    )  # fmt: skip

    def draw(vertices: Floats, segments: Floats, position: float, effort: float) -> None:
        line.points = segments
        share = round(effort_share(actuator, effort) * LEVELS) / LEVELS
        colour = np.array(cable_colour(share), np.uint8)
        line.colors = np.tile(colour, (len(segments), 2, 1))
        line.thickness = width * (_THIN + (_THICK - _THIN) * share)

    return draw


def _spring(scene: viser.SceneApi, look: RobotLook, actuator: DescribedActuator) -> Drawing:
    """A zigzag before the first piece of a cable, as much longer as the spring is."""
    width, unloaded = width_of(look), _SPRING * look.robot.size
    line = scene.add_line_segments(
        f"/springs/{actuator.name}", np.zeros((2 * _COILS, 2, 3), np.float32), SPRING,
        thickness=0.04 * width,
    )  # fmt: skip

    def draw(vertices: Floats, segments: Floats, position: float, effort: float) -> None:
        start, first = segments[0].astype(float)
        length = unloaded + actuator.flexibility * max(effort, 0.0)
        line.points = zigzag(start, start - first, length, 0.15 * width)

    return draw


def _chamber(
    scene: viser.SceneApi, look: RobotLook, actuator: DescribedActuator, triangles: Ints
) -> Drawing:
    """The inner surface, from blue (vacuum) over white to red (pressure)."""
    # opaque: what is transparent may be hidden by the skin around it
    used, corners = np.unique(triangles, return_inverse=True)
    mesh = scene.add_mesh_simple(
        f"/actuators/{actuator.name}", look.vertices[used], corners.reshape(-1, 3).astype(np.uint32),
        color=NO_PRESSURE, side="double", flat_shading=True, cast_shadow=False, receive_shadow=False,
    )  # fmt: skip

    def draw(vertices: Floats, segments: Floats, position: float, effort: float) -> None:
        mesh.vertices = vertices[used]
        share = round(effort_share(actuator, effort) * LEVELS) / LEVELS
        mesh.color = chamber_colour(share if effort >= 0.0 else -share)

    return draw


def _force(scene: viser.SceneApi, look: RobotLook, actuator: DescribedActuator) -> Drawing:
    """An arrow from each point of action, as long as the force is large."""
    size = look.robot.size
    shown = Arrows(scene, f"/actuators/{actuator.name}", FORCE, size, (0.006, 0.014, 0.03))

    def draw(vertices: Floats, segments: Floats, position: float, effort: float) -> None:
        share = effort_share(actuator, effort) * (1.0 if effort >= 0.0 else -1.0)
        starts = segments[:, 0]
        along = (segments[:, 1] - starts) * np.float32(share * _ARROW * size)
        arrows = np.stack([starts, starts + along], axis=1)  # (s, 2, 3)
        shown.draw(arrows if abs(share) > _LEAST else arrows[:0])

    return draw


def _drive(
    scene: viser.SceneApi, look: RobotLook, actuator: DescribedActuator, count: int
) -> Drawing:
    """An axis; of a drive that turns also a hand and the arc of its angle, of a slide its travel."""
    shown = turn_pieces if actuator.kind is ActuatorKind.DRIVE else travel_pieces
    line = scene.add_line_segments(
        f"/actuators/{actuator.name}", np.zeros((count * (_ARC + 3), 2, 3), np.float32), AXIS,
        thickness=0.005 * look.robot.size,
    )  # fmt: skip

    def draw(vertices: Floats, segments: Floats, position: float, effort: float) -> None:
        pieces = [
            shown(start, end - start, position, _RADIUS * look.robot.size)
            for start, end in segments.astype(float)
        ]
        line.points = np.concatenate(pieces).astype(np.float32)

    return draw


def turn_pieces(start: Array, axis: Array, angle: float, radius: float) -> Array:
    """An axis, the hand at angle zero, the hand now, and the arc between them: (_ARC + 3, 2, 3) [m].

    Args:
        start: (3,) point of the axis [m].
        axis: (3,) unit direction.
        angle: of the drive [rad].
        radius: of the arc [m].
    """
    u, v = across(axis)
    angles = np.linspace(0.0, angle, _ARC + 1)[:, None]
    rim = start + radius * (np.cos(angles) * u + np.sin(angles) * v)  # (_ARC + 1, 3)
    lines = [[start - radius * axis, start + radius * axis], [start, rim[0]], [start, rim[-1]]]
    return np.concatenate([np.array(lines), np.stack([rim[:-1], rim[1:]], axis=1)])


def travel_pieces(start: Array, axis: Array, travel: float, radius: float) -> Array:
    """An axis, and a bar across it where the slide is and where it was at rest: (_ARC + 3, 2, 3) [m].

    Args:
        start: (3,) where the slide is [m].
        axis: (3,) unit direction.
        travel: of the slide [m].
        radius: half length of the axis [m].
    """
    side, rest = 0.5 * radius * across(axis)[0], start - travel * axis
    pieces = np.tile(start, (_ARC + 3, 2, 1))
    pieces[0] = [rest - radius * axis, rest + radius * axis]
    pieces[1], pieces[2] = [rest - side, rest + side], [start - side, start + side]
    return pieces


def zigzag(start: Array, direction: Array, length: float, width: float) -> Floats:
    """A zigzag from a point: (2 _COILS, 2, 3) [m].

    Args:
        start: (3,) [m].
        direction: (3,) of its axis, of any length.
        length: [m].
        width: from its axis to a corner [m].
    """
    axis = direction / max(float(np.linalg.norm(direction)), 1e-12)
    along = np.linspace(0.0, length, 2 * _COILS + 1)[:, None]
    side = np.where(np.arange(2 * _COILS + 1) % 2 == 0, -1.0, 1.0)[:, None]
    side[0] = side[-1] = 0.0
    corners = start + along * axis + width * side * across(axis)[0]
    return np.stack([corners[:-1], corners[1:]], axis=1).astype(np.float32)


def width_of(look: RobotLook) -> float:
    """Width of a robot [m]: the middle one of the extents of its skin at rest, of wide robots less."""
    extents = np.sort(np.ptp(look.vertices, axis=0).astype(float))
    return min(float(extents[1]), _SLENDER * look.robot.size)


def effort_share(actuator: DescribedActuator, effort: float) -> float:
    """Effort as a share of its limit, 0 … 1; of one of either sign, of the farther limit."""
    limit = max(abs(actuator.effort[0]), abs(actuator.effort[1]))
    return min(abs(effort) / limit, 1.0) if limit > 0.0 and np.isfinite(effort) else 0.0


def cable_colour(share: float) -> Colour:
    """Colour of a cable at a share 0 … 1 of its largest tension."""
    if share < 0.5:
        return between(SLACK, MIDDLE, 2.0 * share)
    return between(MIDDLE, TIGHT, 2.0 * share - 1.0)


def chamber_colour(share: float) -> Colour:
    """Colour of a chamber at a share −1 (vacuum) … 1 of its largest pressure."""
    return between(NO_PRESSURE, PRESSURE if share >= 0.0 else VACUUM, abs(share))


def between(first: Colour, second: Colour, t: float) -> Colour:
    """A colour between two others.

    Args:
        first: at t = 0.
        second: at t = 1.
        t: 0 … 1.
    """
    r, g, b = (round(a + t * (c - a)) for a, c in zip(first, second, strict=True))
    return r, g, b
