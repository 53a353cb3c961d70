"""Contact bases that select snapshots instead of factoring them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tauten.model.numerics import Array, coordinates
from tauten.reduction.contact.nnmf import Factors


def cone_projected_greedy(S: Array, k: int) -> Iterator[Factors]:
    """Cone-projected greedy: next column = the snapshot farthest from the cone of those chosen.

    The cones are nested: neither the largest nor the mean distance increases with k, and the basis of
    k columns is the first k columns of any larger one. Every mode is a column of S.

    Args:
        S: (n_c, s) snapshots.
        k: number of snapshots to choose.

    Yields:
        For 1, 2, … k: the chosen columns Ψ (n_c, k) and the coordinates B (k, s) of the nearest
        points of their cone.

    Source: Benaceur, Ern, Ehrlacher, Int. J. Numerical Methods in Engineering 121, 2020.
    """
    chosen: list[int] = []
    residual = S
    for _ in range(k):
        distance = np.linalg.norm(residual, axis=0)  # (s,)
        distance[chosen] = -1.0  # zero except for rounding
        chosen.append(int(np.argmax(distance)))
        Psi: Array = S[:, chosen]
        B = coordinates(Psi, S)
        residual = S - Psi @ B
        yield Psi, B
