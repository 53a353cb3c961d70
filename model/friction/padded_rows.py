"""Rows of contacts without friction beside contacts with friction, all as contacts of three rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Bools, Ints


@dataclass(frozen=True, slots=True)
class PaddedRows:
    """Rows as contacts of three rows each.

    Attributes:
        W: (3 k, 3 k) compliance [m/N].
        q: (3 k,) row values without forces [m].
        mu: (k,) coefficients of friction.
        place: (m,) where each row is among them.
    """

    W: Array
    q: Array
    mu: Array
    place: Ints


def padded_rows(W: Array, delta: Array, friction: Array) -> PaddedRows:
    """Rows of single contacts, then three of each contact with friction, as contacts of three rows each.

    A single row gets two more, with its own compliance and neither motion nor friction.

    Args:
        W: (s + 3 r, s + 3 r) compliance [m/N].
        delta: (s + 3 r,) row values without forces [m].
        friction: (r,) coefficients of friction.
    """
    s, place = len(delta) - 3 * len(friction), padded_places(len(delta), len(friction))
    if s == 0:
        return PaddedRows(W.copy(), delta.copy(), friction, place)
    padded, q = np.zeros((2 * s + len(delta),) * 2), np.zeros(2 * s + len(delta))
    padded[place[:, None], place] = W
    q[place] = delta
    more = np.concatenate([place[:s] + 1, place[:s] + 2])
    padded[more, more] = np.tile(np.diag(W)[:s], 2)
    return PaddedRows(padded, q, np.concatenate([np.zeros(s), friction]), place)


def padded_places(rows: int, frictional: int) -> Ints:
    """Where rows (m,), the last of which are of contacts with friction, are among those of `padded_rows`.

    Args:
        rows: their number m.
        frictional: number of contacts with friction.
    """
    s = rows - 3 * frictional
    return np.concatenate([3 * np.arange(s), np.arange(3 * s, 2 * s + rows)])


def moving_contacts(W: Array) -> tuple[Bools, Ints]:
    """Which contacts of three rows (k,) have a compliance, and their rows; others are on what is fixed.

    Args:
        W: (3 k, 3 k) compliance [m/N].
    """
    moves: Bools = np.diag(W).reshape(-1, 3).max(axis=1) > 0.0
    return moves, np.flatnonzero(np.repeat(moves, 3))
