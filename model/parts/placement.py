"""Where the frame of a part stands in the frame of its robot."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model.numerics import Array


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """A rotation, then a displacement: x = Q x_part + position.

    Attributes:
        Q: (3, 3) rotation from the part's frame to the robot's.
        position: (3,) origin of the part's frame in the robot's [m].
    """

    Q: Array
    position: Array

    def points(self, x: Array) -> Array:
        """Positions (…, 3) in the robot's frame of positions in the part's [m]."""
        return self.vectors(x) + self.position

    def vectors(self, v: Array) -> Array:
        """Vectors (…, 3) in the robot's frame of vectors in the part's."""
        turned: Array = v @ self.Q.T
        return turned

    def into_part(self, v: Array) -> Array:
        """Vectors (…, 3) in the part's frame of vectors in the robot's."""
        turned: Array = v @ self.Q
        return turned
