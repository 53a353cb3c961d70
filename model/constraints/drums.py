"""Drums: motors that wind several cables at once, each by its gain, and cables that go slack.

The motor has a coordinate θ. Cable i is wound to the length g_i θ, its own pulled length is δ_i, and a spring
of stiffness k_i in series with it, whose tension at rest is p_i, takes up the difference:

    e_i = p_i / k_i + g_i θ − δ_i,   λ_i = k_i max(e_i, 0),   E = Σ ½ k_i max(e_i, 0)²              (A3)

so that the effort of the motor is ∂E/∂θ = Σ g_i λ_i, and the force on the robot H_iᵀ λ_i. A cable that has
gone slack keeps a small share of its stiffness in the tangent, not in the forces, so that the motor's
coordinate is never free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model.numerics import Array, Ints
from tauten.model.points import NodePoints, Paths, segment_nodes

SLACK_SHARE = 1e-6  # of the stiffness of a slack cable in the tangent


@dataclass(frozen=True, slots=True)
class Drums:
    """The drums of a robot and the cables on them.

    Attributes:
        cables: (c,) numbers of the cables on drums.
        owner: (c,) the drum of each.
        gains: (c,) wound length by a unit of the drum's coordinate, signed.
        stiffness: (c,) of the springs [N/m].
        pretension: (c,) tension at rest [N].
        motors: (d,) numbers of the drums among the motors of the robot.
        regions: (d,) their numbers among the drive regions, which have no nodes.
        supports: of each cable the degrees of freedom of nodes, those not fixed, that its length depends on.
    """

    cables: Ints
    owner: Ints
    gains: Array
    stiffness: Array
    pretension: Array
    motors: Ints
    regions: Ints
    supports: tuple[Ints, ...]

    def tensions(self, delta: Array, theta: Array) -> Array:
        """Tensions λ (c,) [N] of the cables on drums, of delta of all cables [m] and theta (d,) of drums."""
        wound = self.pretension / self.stiffness + self.gains * theta[self.owner]
        tension: Array = self.stiffness * np.maximum(wound - delta[self.cables], 0.0)
        return tension

    def held_by(self, tension: Array) -> Array:
        """Stiffness of the springs (c,) in the tangent under tensions (c,) [N/m]."""
        return np.where(tension > 0.0, 1.0, SLACK_SHARE) * self.stiffness

    def energy(self, delta: Array, theta: Array) -> float:
        """Energy in the springs since rest [J]; arguments as of `tensions`."""
        tension = self.tensions(delta, theta)
        return float(0.5 * ((tension**2 - self.pretension**2) / self.stiffness).sum())

    def efforts(self, tension: Array) -> Array:
        """Efforts of the motors (d,) that hold tensions (c,) [N]."""
        return np.bincount(self.owner, self.gains * tension, len(self.motors)).astype(float)

    def entries(self, first: int) -> tuple[Ints, Ints]:
        """Rows and columns of the entries that `tangent` gives, where the first drum has the row `first`."""
        rows, columns = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
        for support, drum in zip(self.supports, self.owner.tolist(), strict=True):
            places = np.append(support, first + drum)
            rows.append(np.repeat(places, len(places)))
            columns.append(np.tile(places, len(places)))
        return np.concatenate(rows), np.concatenate(columns)

    def tangent(self, H: sp.csr_array, tension: Array) -> Array:
        """Values of the tangent k h hᵀ of each cable, h = ∂(δ − g θ), without the curvature of the cables.

        Of rows H of all cables over the nodes that are not fixed, and tensions (c,) of those on drums [N].
        """
        values, stiffness = [np.zeros(0)], self.held_by(tension)
        for place, support in enumerate(self.supports):
            dense = H[[self.cables[place]]].toarray()[0]
            h = np.append(dense[support], -self.gains[place])
            values.append(stiffness[place] * np.outer(h, h).ravel())
        return np.concatenate(values)


def supports_of(
    paths: Paths, stations: NodePoints, chosen: list[int], number: Ints
) -> tuple[Ints, ...]:
    """Degrees of freedom that the lengths of cables depend on, as `Drums` has them.

    Args:
        paths: of all cables of the robot.
        stations: points that they pass.
        chosen: numbers of those on drums.
        number: (n_nodes,) number of each node among those that are not fixed, −1 where it is fixed.
    """
    found, nodes_of = [], segment_nodes(paths, stations)
    for cable in chosen:
        nodes = np.unique(number[nodes_of[paths.owner == cable]])
        found.append((3 * nodes[nodes >= 0][:, None] + np.arange(3)).ravel())
    return tuple(found)
