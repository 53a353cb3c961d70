"""What is drawn of a robot and around it: skin, actuators, contacts that push, held places, obstacles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauten.model.contact import ObstaclePose, RodOutline
from tauten.model.contacts import ContactForces
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.robot.robot import Robot
from tauten.model.state import State

_TRIAL = 1e-3  # change of every coordinate, in metres or radians, under which a held vertex stays
_STILL = 1e-9  # of it, above the rounding of positions
_AROUND = 2.0  # how much of an obstacle without end is drawn, as a multiple of the robot's size
Floats: TypeAlias = NDArray[np.float32]  # positions for drawing

_PUSHING = 1e-3  # of the largest force; smaller ones are not drawn
_FRICTION = 1e-4  # coefficient below which there is none: rounding


@dataclass(frozen=True, slots=True)
class PushingContacts:
    """Contacts that push.

    Attributes:
        points: (c, 3) [m].
        forces: (c, 3) on the body at these points [N].
        normals: (c, 3) unit directions in which they push without friction.
        sliding: (c,) which slide; without friction all do.
        margin: (c,) distance to slip of those that stick, 0 of others [N].
    """

    points: Floats
    forces: Floats
    normals: Floats
    sliding: Bools
    margin: Floats

    @property
    def friction(self) -> Floats:
        """Coefficient of friction of each: (c,)."""
        normal = np.einsum("ci,ci->c", self.forces, self.normals)
        across = np.linalg.norm(self.forces - normal[:, None] * self.normals, axis=1)
        found = (self.margin + across) / np.maximum(normal, 1e-30)
        return np.where(found > _FRICTION, found, 0.0).astype(np.float32)

    @property
    def nbytes(self) -> int:
        """Memory of its arrays [bytes]."""
        arrays = (self.points, self.forces, self.normals, self.sliding, self.margin)
        return sum(array.nbytes for array in arrays)


_NOWHERE = np.zeros((0, 3), np.float32)
NO_CONTACTS = PushingContacts(
    _NOWHERE, _NOWHERE, _NOWHERE, np.zeros(0, np.bool_), np.zeros(0, np.float32)
)


@dataclass(frozen=True, slots=True)
class Geometry:
    """Where a robot is.

    Attributes:
        vertices: (P, 3) of its skin [m].
        segments: (s, 2, 3) segments of the actuators [m], see `Robot.actuator_segments`.
        contacts: that push.
    """

    vertices: Floats
    segments: Floats
    contacts: PushingContacts


@dataclass(frozen=True, slots=True)
class SkinMesh:
    """The vertices of a robot's surface among its points.

    Attributes:
        used: (P,) which of the robot's points they are.
        triangles: (t, 3) of the vertices.
    """

    used: Ints
    triangles: Ints

    def geometry(self, robot: Robot, state: State, found: ContactForces | None) -> Geometry:
        """Where the robot of this skin is at a state, with the contacts in range that have these forces.

        Without contacts it is faster.
        """
        return Geometry(
            robot.points(state)[self.used].astype(np.float32),
            robot.actuator_segments(state).astype(np.float32),
            NO_CONTACTS if found is None else pushing_contacts(robot, state, found),
        )


def skin_of(robot: Robot) -> SkinMesh:
    """The skin of a robot."""
    used, inverse = np.unique(robot.triangles, return_inverse=True)
    return SkinMesh(used, inverse.reshape(-1, 3))


def pushing_contacts(robot: Robot, state: State, found: ContactForces) -> PushingContacts:
    """Contacts that push in a state."""
    lam = np.linalg.norm(found.force, axis=1)
    largest = float(lam.max(initial=0.0))
    if not largest > 0.0:
        return NO_CONTACTS
    shown = np.flatnonzero(lam > _PUSHING * largest)
    points = robot.candidates(state)[found.contacts.slots[shown]]
    return PushingContacts(
        points.astype(np.float32), found.force[shown].astype(np.float32),
        found.contacts.normal[shown].astype(np.float32), found.sliding[shown],
        found.margin[shown].astype(np.float32),
    )  # fmt: skip


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
