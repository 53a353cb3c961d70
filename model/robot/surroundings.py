"""What stands still around a robot, for drawing: where it is held, and the obstacles that it may touch."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model.contact import DrawnShape
from tauten.model.numerics import Array, Ints
from tauten.model.robot.robot import Robot
from tauten.model.robot.skin import SkinMesh

_TRIAL = 1e-3  # change of every coordinate, in metres or radians, under which a held vertex stays
_STILL = 1e-9  # of it, above the rounding of positions
_AROUND = 2.0  # how much of an obstacle without end is drawn, as a multiple of the robot's size


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A shape that stands still.

    Attributes:
        name: of the contact that it belongs to.
        vertices: (v, 3) of its surface [m].
        triangles: (t, 3) of them.
    """

    name: str
    vertices: Array
    triangles: Ints


def held_vertices(robot: Robot, skin: SkinMesh) -> Ints:
    """Numbers (m,) of the skin's vertices that no motion of the robot moves.

    Args:
        robot: the robot.
        skin: its skin.
    """
    rest = robot.rest()
    change = _TRIAL * np.random.default_rng(0).choice([-1.0, 1.0], len(rest.q))
    before, after = robot.points(rest), robot.points(replace(rest, q=rest.q + change))
    moved = np.linalg.norm(after - before, axis=1)[skin.used]
    return np.flatnonzero(moved <= _STILL * _TRIAL)


def obstacles_of(robot: Robot) -> tuple[Obstacle, ...]:
    """The obstacles that a robot may touch; without those of packages that say not how they are drawn."""
    centre = robot.points(robot.rest()).mean(axis=0)
    found: dict[int, Obstacle] = {}
    for pair in robot.contacts.pairs:
        if isinstance(pair.shape, DrawnShape) and id(pair.shape) not in found:
            drawn = pair.shape.outline(centre, _AROUND * robot.size)
            found[id(pair.shape)] = Obstacle(pair.name, *drawn)
    return tuple(one for one in found.values() if len(one.triangles))
