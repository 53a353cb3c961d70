"""What of a robot is drawn: the skin of its deformed body, its actuators, the contacts that push."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauten.model.contacts import ContactForces
from tauten.model.numerics import Bools, Ints
from tauten.model.robot.robot import Robot
from tauten.model.state import State

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
        """Where a robot is.

        Args:
            robot: whose skin this is.
            state: of the robot.
            found: contacts in range with their forces; None: they are left out, which is
                faster.
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
