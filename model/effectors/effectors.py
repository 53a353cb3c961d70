"""The effectors of a robot: functions of points of its body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from tauten.model.effectors.effector_set import EffectorSet
from tauten.model.numerics import Array
from tauten.model.points import Motion, OuterForces
from tauten.model.rows import EffectorRows, Rows

P_co = TypeVar("P_co", covariant=True)


@dataclass(frozen=True, slots=True)
class Effectors(Generic[P_co]):
    """Effectors over points of a body, which are of type P_co (`tauten.model.points.Motion`).

    The points of a frame are its origin and columns of A of (E1): of tetrahedra the mean and moments of a
    region; of beams, for axis k, the difference of two points of the node, at the distance e_k and at the
    node itself, so that A is the node's rotation.

    Attributes:
        kinds: the effectors as functions of the points.
        points: the points.
    """

    kinds: EffectorSet
    points: P_co

    def positions(self, motion: Motion[P_co]) -> Array:
        """Positions (p, 3) of the effectors [m]."""
        return self.kinds.positions(motion.placed(self.points).y)

    def values(self, motion: Motion[P_co]) -> Array:
        """Goal values (n_v,) of the effectors."""
        return self.kinds.values(motion.placed(self.points).y)

    def rows(self, motion: Motion[P_co]) -> EffectorRows:
        """Rows of the effectors."""
        return self.kinds.rows(motion.placed(self.points))

    def pushed(self, forces: Array) -> OuterForces[P_co]:
        """Outer forces on the effectors as forces on the points.

        Args:
            forces: (3 p,) [N].
        """
        pairs = zip(self.kinds.measures, forces.reshape(-1, 3), strict=True)
        vectors = [np.outer(measure.carrier, force) for measure, force in pairs]
        return OuterForces(self.points, np.concatenate([np.zeros((0, 3)), *vectors]))

    def places(self, motion: Motion[P_co]) -> Rows:
        """Positions (3 p,) of the places where outer forces act on the effectors."""
        return self.kinds.places(motion.placed(self.points))
