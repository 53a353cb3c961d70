"""What is around a robot, for drawing: where it is held, and the obstacles that it may touch."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model.contact import ObstaclePose, RodOutline
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
        rod: what the triangles are made from, of a round obstacle.
    """

    name: str
    vertices: Array
    triangles: Ints
    pose: ObstaclePose
    rod: RodOutline | None


def held_vertices(robot: Robot, skin: SkinMesh) -> Ints:
    """Numbers (m,) of the skin's vertices that no motion of the robot moves."""
    rest = robot.rest()
    change = _TRIAL * np.random.default_rng(0).choice([-1.0, 1.0], len(rest.q))
    before, after = robot.points(rest), robot.points(replace(rest, q=rest.q + change))
    moved = np.linalg.norm(after - before, axis=1)[skin.used]
    return np.flatnonzero(moved <= _STILL * _TRIAL)


def touched_names(robot: Robot) -> tuple[str, ...]:
    """Names of the obstacles of a robot, and of its parts that have contacts."""
    owners = (name for pair in robot.contacts.pairs for name in (pair.owner, pair.other) if name)
    return (*robot.obstacles.names, *dict.fromkeys(owners))


def contact_wrenches(robot: Robot, found: ContactForces) -> Array:
    """Force [N] and torque about the origin [N m] by contact on each of `touched_names`: (o, 6).

    On an obstacle it is that of the robot, on a part that of obstacles and other parts.
    """
    names, pair = touched_names(robot), found.contacts.pair
    own = np.hstack([found.force, np.cross(found.contacts.point, found.force)])  # (m, 6)
    wrench = np.zeros((len(names), 6))
    for number, one in enumerate(robot.contacts.pairs):
        whole = own[pair == number].sum(axis=0)
        against = one.other if one.obstacle is None else one.obstacle.name
        if one.owner:
            wrench[names.index(one.owner)] += whole
        if against:
            wrench[names.index(against)] -= whole
    return wrench


def obstacles_of(robot: Robot) -> tuple[ObstacleOutline, ...]:
    """The obstacles that a robot may touch; without those of packages that say not how they are drawn."""
    centre, found = robot.points(robot.rest()).mean(axis=0), robot.obstacles
    outlines = [
        ObstacleOutline(
            one.name,
            *one.outline(pose, centre, _AROUND * robot.size),
            pose,
            getattr(one.shape, "rod", None),
        )
        for one, pose in zip(found.obstacles, found.poses, strict=True)
    ]
    return tuple(one for one in outlines if len(one.triangles))
