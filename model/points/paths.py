"""Paths of cables through points: pulled lengths and their rows, for all bodies.

δ_a = L(q₀) − L(q) is the length pulled in, H_a = −∂L/∂q, the force on the body is H_aᵀ λ_a.

An equilibrium in which the ends of a segment have met is common: a trunk curls until its discs meet. There
|d| has a kink, which Newton's method does not pass, so that lengths are rounded below `SHORTEST`, or below
half of the segment's length at rest where that is less: segments of small robots are straight too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.points.entries import Entries, Placed
from tauten.model.rows import Rows

SHORTEST = 5e-4  # m, largest distance of a segment's ends below which its length is rounded
_LEAST = 1e-5  # m, the least one, of segments whose ends meet at rest
Segments: TypeAlias = tuple[Ints, Ints, Array]  # first station, cable and shortest of each


@dataclass(frozen=True, slots=True)
class Paths:
    """Cables through stations, points that they pass one after the other.

    Attributes:
        starts: (n_a + 1,) where each cable's stations start.
        stations: (p,) their numbers, 0 to p − 1.
        first: (s,) first station of every segment, cable by cable; the second one is the next.
        owner: (s,) cable of every segment.
        shortest: (s,) distance of the ends below which the length is rounded [m].
        rest_length: (n_a,) L(q₀) [m].
    """

    starts: Ints
    stations: Ints
    first: Ints
    owner: Ints
    shortest: Array
    rest_length: Array

    @property
    def n_a(self) -> int:
        """Number of cables."""
        return len(self.rest_length)

    @property
    def segment_arrays(self) -> Segments:
        """First station, cable and shortest of all segments, for the kernels."""
        return self.first, self.owner, self.shortest

    def rows(self, placed: Placed) -> Rows:
        """Pulled lengths and H_a = −∂L/∂q: Rows of (n_a, n) [m]."""
        length, vectors = np.zeros(len(self.rest_length)), np.zeros(placed.y.shape)
        add_lengths(placed.y, self.starts, self.shortest, length, vectors)
        H = placed.rows(Entries(self.starts, self.stations, vectors))
        return Rows(H, self.rest_length - length)

    def segments(self, y: Array) -> Array:
        """Both ends of every segment for stations y (p, 3): (s, 2, 3) [m], for drawing."""
        return np.stack([y[self.first], y[self.first + 1]], axis=1)


def make_paths(counts: list[int], y: Array) -> Paths:
    """Paths at rest, of cables with `counts` stations each, which are at y (p, 3), cable by cable [m]."""
    starts = np.cumsum([0, *counts]).astype(np.int64)
    stations = np.arange(starts[-1])
    owner = np.repeat(np.arange(len(counts)), np.array(counts, dtype=np.int64) - 1)
    first = np.setdiff1d(stations, starts[1:] - 1)
    apart = np.linalg.norm(y[first + 1] - y[first], axis=1)
    shortest = np.clip(0.5 * apart, _LEAST, SHORTEST)
    rest_length, _ = path_lengths(y, starts, shortest)
    return Paths(starts, stations, first, owner, shortest, rest_length)


@kernel
def blunted(length: float, shortest: float) -> tuple[float, float, float]:
    """Length f of a segment as the cable has it [m], f'(length) / length and f''(length) [1/m].

    |d| itself from the shortest on; below, the even polynomial of fourth degree that continues it with two
    derivatives.

    Args:
        length: distance of the segment's ends [m].
        shortest: below which it is rounded, positive [m].
    """
    if length >= shortest:
        return length, 1.0 / length, 0.0
    t = length / shortest
    value = shortest * (0.375 + 0.75 * t * t - 0.125 * t**4)
    return value, (1.5 - 0.5 * t * t) / shortest, 1.5 * (1.0 - t * t) / shortest


def path_lengths(y: Array, starts: Ints, shortest: Array) -> tuple[Array, Array]:
    """Lengths (n_a,) of the cables [m] and −∂length by their stations (p, 3).

    Args:
        y: (p, 3) stations [m].
        starts: (n_a + 1,) where each cable's stations start.
        shortest: (s,) of every segment, cable by cable, distance below which its length is rounded [m].
    """
    length, vectors = np.zeros(len(starts) - 1), np.zeros(y.shape)
    add_lengths(y, starts, shortest, length, vectors)
    return length, vectors


@kernel
def add_lengths(y: Array, starts: Ints, shortest: Array, length: Array, vectors: Array) -> None:
    """Add what `path_lengths` gives to arrays.

    Args:
        y: (p, 3) as there.
        starts: (n_a + 1,) as there.
        shortest: (s,) as there.
        length: (n_a,) added to [m].
        vectors: (p, 3) added to.
    """
    d = np.empty(3)
    for cable in range(starts.shape[0] - 1):
        for p in range(starts[cable], starts[cable + 1] - 1):
            for i in range(3):
                d[i] = y[p + 1, i] - y[p, i]
            ell = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
            value, slope, _ = blunted(ell, shortest[p - cable])
            length[cable] += value
            for i in range(3):
                vectors[p, i] += slope * d[i]
                vectors[p + 1, i] -= slope * d[i]
