"""What is around a robot, for drawing: where it is held, and the obstacles that it may touch."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model.contact import ObstaclePose
from tauten.model.contacts import ContactForces
from tauten.model.numerics import Array, Ints
from tauten.model.robot.robot import Robot
from tauten.model.robot.skin import SkinMesh

_TRIAL = 1e-3  # change of every coordinate, in metres or radians, under which a held vertex stays
_STILL = 1e-9  # of it, above the rounding of positions
_AROUND = 2.0  # how much of an obstacle without end is drawn, as a multiple of the robot's size


@dataclass(frozen=True, slots=True)
class ObstacleOutline:
    """An obstacle as it is drawn.

    Attributes:
        name: of the obstacle.
        vertices: (v, 3) of its surface in its own frame [m].
        triangles: (t, 3) of them.
        pose: of that frame.
    """

    name: str
    vertices: Array
    triangles: Ints
    pose: ObstaclePose


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


def obstacle_wrenches(robot: Robot, found: ContactForces) -> Array:
    """Force [N] and torque about the origin [N m] of the robot on each of its obstacles: (o, 6).

    Args:
        robot: the robot.
        found: contacts in range with their forces.
    """
    names = robot.obstacles.names
    pairs = robot.contacts.pairs
    owner = [-1 if pair.obstacle is None else names.index(pair.obstacle.name) for pair in pairs]
    own = np.array(owner, dtype=np.int64)[found.contacts.pair]  # (m,)
    wrench, on = np.zeros((len(names), 6)), own >= 0
    both = -np.hstack([found.force, np.cross(found.contacts.point, found.force)])  # (m, 6)
    np.add.at(wrench, own[on], both[on])
    return wrench


def obstacles_of(robot: Robot) -> tuple[ObstacleOutline, ...]:
    """The obstacles that a robot may touch; without those of packages that say not how they are drawn."""
    centre, found = robot.points(robot.rest()).mean(axis=0), robot.obstacles
    outlines = [
        ObstacleOutline(one.name, *one.outline(pose, centre, _AROUND * robot.size), pose)
        for one, pose in zip(found.obstacles, found.poses, strict=True)
    ]
    return tuple(one for one in outlines if len(one.triangles))
