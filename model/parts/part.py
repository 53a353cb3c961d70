"""A part of a robot: a robot in a place, with unknowns, forces and bases of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from tauten.model.numerics import Array
from tauten.model.robot import Robot
from tauten.model.schema import RotationSettings


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
    """A part: what is coupled by coordinates or by elasticity.

    Attributes:
        name: of the part, used once.
        robot: the part in its own frame, as its file describes it.
        placement: where that frame stands in the frame of all parts.
    """

    name: str
    robot: Robot
    placement: Placement

    def named(self, name: str) -> str:
        """What an actuator or effector of the part is called among those of all parts."""
        return f"{self.name}_{name}"

    def made_of(self, robot: Robot) -> Part:
        """The part with another robot in the same place: reduced, under other loads, another workspace."""
        return replace(self, robot=robot)
