"""A part of a robot, which is a robot in a place, and what makes one robot of parts beside these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from tauten.model.contact import ContactPair
from tauten.model.numerics import Array, Ints
from tauten.model.robot import Robot
from tauten.model.schema import CouplingSettings, RotationSettings


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """A rotation, then a displacement: x = Q x_part + position.

    Attributes:
        Q: (3, 3) rotation from the part's frame to the robot's.
        position: (3,) origin of the part's frame in the robot's [m].
    """

    Q: Array
    position: Array

    @classmethod
    def of(cls, rotation: RotationSettings | None, position: Sequence[float]) -> Placement:
        """The placement of the fields of a robot file."""
        if rotation is None:
            return cls(np.eye(3), np.array(position))
        w, x, y, z = rotation.unit_quaternion
        return cls(Rotation.from_quat([x, y, z, w]).as_matrix(), np.array(position))

    @property
    def elsewhere(self) -> Placement | None:
        """The placement; None where the part's frame is the robot's."""
        here = np.array_equal(self.Q, np.eye(3)) and not self.position.any()
        return None if here else self

    def points(self, x: Array) -> Array:
        """Positions (…, 3) in the robot's frame of positions in the part's [m]."""
        return self.vectors(x) + self.position

    def vectors(self, v: Array) -> Array:
        """Vectors (…, 3) in the robot's frame of vectors in the part's."""
        turned: Array = v @ self.Q.T
        return turned

    def points_in_part(self, x: Array) -> Array:
        """Positions (…, 3) in the part's frame of positions in the robot's [m]."""
        return self.into_part(x - self.position)

    def into_part(self, v: Array) -> Array:
        """Vectors (…, 3) in the part's frame of vectors in the robot's."""
        turned: Array = v @ self.Q
        return turned


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """What is coupled by coordinates or by elasticity: a robot as in its file, placed among others."""

    name: str
    robot: Robot
    placement: Placement

    def named(self, name: str) -> str:
        """What an actuator or effector of the part is called among those of all parts."""
        return f"{self.name}_{name}"

    def made_of(self, robot: Robot) -> Part:
        """The part with another robot in the same place: reduced, under other loads, another workspace."""
        return replace(self, robot=robot)


@dataclass(frozen=True, slots=True, eq=False)
class Between:
    """Contact between parts.

    Attributes:
        vertices: (v,) vertices of the surfaces of each part that touch another, by their numbers in the part.
        pairs: over these vertices, those of one part after those of the other.
    """

    vertices: tuple[Ints, ...]
    pairs: tuple[ContactPair, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Assembly:
    """What makes one robot of parts.

    Attributes:
        name: of the robot.
        frame: frame id of its positions.
        digest: what its contact forces depend on.
        gravity: (3,) in its frame [m/s²].
        tolerance: depth of penetration from which a unit column is added [m].
        alarm_distance: largest distance of contact that is reported [m].
        distance: at which surfaces are held from each other [m].
        between: contact between parts.
        couplings: motors that drive actuators of several parts, which have the names of these.
        max_force: sum of the normal forces of all contacts that decisions keep at most [N]; None: any.
    """

    name: str
    frame: str
    digest: str
    gravity: Array
    tolerance: float
    alarm_distance: float
    distance: float
    between: Between
    couplings: tuple[CouplingSettings, ...] = ()
    max_force: float | None = None
