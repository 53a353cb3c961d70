"""All effectors of a robot over the points that they are functions of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model.effectors.measure import Measure, Measurement
from tauten.model.interface import EffectorLayout
from tauten.model.numerics import Array, Ints
from tauten.model.rows import EffectorRows, Jacobian


@dataclass(frozen=True, slots=True)
class EffectorSet:
    """Effectors in row order, each a function of some points of one list.

    Attributes:
        layout: kinds, weights, places of rows and values.
        measures: the functions.
        starts: (p + 1,) first point of each effector.
    """

    layout: EffectorLayout
    measures: tuple[Measure, ...]
    starts: Ints

    def __len__(self) -> int:
        return len(self.measures)

    @property
    def one_point_each(self) -> bool:
        """Whether rows are the positions of the points themselves."""
        return self.layout.positions_only and int(self.starts[-1]) == len(self)

    def measured(self, y: Array) -> list[Measurement]:
        """Every effector for positions y (P, 3) of all points [m]."""
        starts = self.starts.tolist()
        return [
            measure.at(y[first:end])
            for measure, first, end in zip(self.measures, starts[:-1], starts[1:], strict=True)
        ]

    def values(self, y: Array) -> Array:
        """Goal values (n_v,) for positions y (P, 3) of all points [m]."""
        if self.one_point_each:
            return y.ravel()
        return np.concatenate([found.values for found in self.measured(y)])

    def positions(self, y: Array) -> Array:
        """Positions (p, 3) of the effectors for positions y (P, 3) of all points [m]."""
        if self.one_point_each:
            return y
        return np.array([found.position for found in self.measured(y)])

    def rows(self, y: Array, C: Jacobian) -> EffectorRows:
        """Rows over the degrees of freedom.

        Args:
            y: (P, 3) positions of all points [m].
            C: (3 P, n) their derivative.
        """
        if self.one_point_each:
            return EffectorRows(C, y.ravel(), y.ravel(), y)
        found = self.measured(y)
        return joined_rows(found, self.by_configuration(found, C))

    def by_configuration(self, found: list[Measurement], C: Jacobian) -> Jacobian:
        """H (n_e, n) of measured effectors; arguments as of `rows`."""
        if isinstance(C, np.ndarray):
            starts = 3 * self.starts
            parts = [
                item.gradient.reshape(len(item.delta), -1) @ C[starts[i] : starts[i + 1]]
                for i, item in enumerate(found)
            ]
            return np.concatenate(parts)
        blocks = [sp.coo_array(item.gradient.reshape(len(item.delta), -1)) for item in found]
        return sp.csr_array(sp.block_diag(blocks, format="csr") @ C)

    def force_map(self, C: Jacobian) -> Jacobian:
        """Derivative (3 p, n) of the places where outer forces act on the effectors.

        Args:
            C: (3 P, n) derivative of the points.
        """
        carriers = [sp.coo_array(measure.carrier[None]) for measure in self.measures]
        weights = sp.block_diag(carriers)  # (p, P)
        combined = sp.csr_array(sp.kron(weights, sp.eye_array(3)))
        return combined @ C


def joined_rows(found: list[Measurement], H: Jacobian) -> EffectorRows:
    """Rows of measured effectors with the Jacobian H (n_e, n)."""
    return EffectorRows(
        H,
        np.concatenate([item.delta for item in found]),
        np.concatenate([item.values for item in found]),
        np.array([item.position for item in found]),
    )
