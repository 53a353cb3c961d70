"""Rows of contacts without friction beside contacts with friction, all as contacts of three rows."""

from __future__ import annotations

import numpy as np

from tauten.model.friction.problem import Cones
from tauten.model.numerics import Array, Bools, Ints, kernel


@kernel
def padded_rows(W: Array, delta: Array, friction: Array) -> Cones:
    """Rows of single contacts, then three of each contact with friction, as contacts of three rows each.

    A single row gets two more, with its own compliance and neither motion nor friction.

    Args:
        W: (s + 3 r, s + 3 r) compliance [m/N].
        delta: (s + 3 r,) row values without forces [m].
        friction: (r,) coefficients of friction.
    """
    rows, place = len(delta), padded_places(len(delta), len(friction))
    s = rows - 3 * len(friction)
    k = s + len(friction)
    padded, q = np.zeros((3 * k, 3 * k)), np.zeros(3 * k)
    mu, W_ii = np.zeros(k), np.zeros(k)
    mu[s:] = friction
    for i in range(rows):
        at = place[i]
        q[at] = delta[i]
        for j in range(rows):
            padded[at, place[j]] = W[i, j]
        if i < s:
            padded[at + 1, at + 1] = padded[at + 2, at + 2] = W[i, i]
    for i in range(k):
        W_ii[i] = largest_compliance(padded[3 * i : 3 * i + 3, 3 * i : 3 * i + 3])
    return Cones(padded, q, mu, W_ii)


@kernel
def largest_compliance(W: Array) -> float:
    """Largest compliance of a contact (3, 3) along its normal or in any direction across it.

    That of a row depends on which tangents the rows are along, which must not matter.
    """
    apart = 0.5 * (W[1, 1] - W[2, 2])
    across = 0.5 * (W[1, 1] + W[2, 2]) + np.sqrt(apart * apart + W[1, 2] * W[1, 2])
    return float(max(W[0, 0], across))


@kernel
def padded_places(rows: int, frictional: int) -> Ints:
    """Where rows (m,), the last of which are of contacts with friction, are among those of `padded_rows`."""
    s, place = rows - 3 * frictional, np.empty(rows, np.int64)
    for i in range(rows):
        place[i] = 3 * i if i < s else 2 * s + i
    return place


def moving_contacts(W: Array) -> tuple[Bools, Ints]:
    """Which contacts (k,) move by W (3 k, 3 k) [m/N], and their rows; the others are on what is fixed."""
    moves: Bools = np.diag(W).reshape(-1, 3).max(axis=1) > 0.0
    return moves, np.flatnonzero(np.repeat(moves, 3))
