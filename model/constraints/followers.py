"""Nodes that follow others: glued ones, and those of pinned regions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model.constraints.frames import PinnedRegion
from tauten.model.numerics import Array, Ints, joined


@dataclass(frozen=True, slots=True)
class GluedNodes:
    """Nodes that are weighted means of others.

    Attributes:
        nodes: (g,) the nodes that are glued.
        masters: (g, 4) the nodes they follow, none of them glued.
        weights: (g, 4) rows sum to one.
    """

    nodes: Ints
    masters: Ints
    weights: Array


def joined_followers(pinned: list[PinnedRegion], glued: GluedNodes) -> GluedNodes:
    """Glued nodes, and the nodes of pinned regions with what their pin follows."""
    sizes = [(len(one.nodes), 1) for one in pinned]
    of_pins = [
        GluedNodes(one.nodes, np.tile(one.masters, size), np.tile(one.weights, size))
        for one, size in zip(pinned, sizes, strict=True)
    ]
    return joined([glued, *of_pins])


def follow_matrices(
    followers: Ints, glued: Ints, masters: Ints, weights: Array, m: int
) -> tuple[sp.csr_array, sp.csr_array]:
    """Positions of all nodes that are not fixed from those that are not glued, and from shifts of any node.

    A follower may follow another one, as in a chain of links: (I − W)⁻¹ = I + W + W² + …, which ends.

    Args:
        followers: (g,) nodes that follow others.
        glued: those of them that do nothing else; pinned ones move against their pin too.
        masters: (g, 4) what they follow, −1 where that is fixed.
        weights: (g, 4) their weights.
        m: nodes that are not fixed.

    Returns:
        `own` and `all`, both (m, m), with x = all (own x + shift).
    """
    rows, columns, values = np.repeat(followers, 4), masters.ravel(), weights.ravel()
    known = (columns >= 0) & (values != 0.0)
    W = sp.csr_array((values[known], (rows[known], columns[known])), shape=(m, m))
    everything = power = sp.csr_array(sp.eye_array(m, format="csr"))
    for _ in range(m):
        power = sp.csr_array(W @ power)
        if power.nnz == 0:
            break
        everything = sp.csr_array(everything + power)
    moves = np.ones(m)
    moves[glued] = 0.0
    own = sp.csr_array(everything @ sp.diags_array(moves))
    own.eliminate_zeros()
    return own, everything
