"""Transmissions: motors that act on points of the body through a function of them, which anybody may write.

The position is the value of the function less that at rest, δ = f(y) − f(y₀). With an effort λ, which does
the work λ dδ, the force on each point is λ ∂f/∂y, and the tangent gains −λ ∂²f/∂y². A function that does not
give its second derivative leaves this out: forces and rows remain exact, so that equilibria are the same, but
steps and iterations follow them as well as an approximate tangent does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Generic, Protocol, TypeVar

import numpy as np

from tauten.model.extension_error import answer_of, shape_fault
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.points import Entries, Motion
from tauten.model.rows import Jacobian, Rows, dense
from tauten.model.system import Pattern

_STEP = 6e-6  # of differences, relative to the distance of points: cube root of the rounding
_CLOSE = 1e-2  # m, distance of points that are closer to each other
P = TypeVar("P")
P_co = TypeVar("P_co", covariant=True)
Q = TypeVar("Q")


@dataclass(frozen=True, slots=True)
class Transmitted:
    """A function of points at some positions of these.

    Attributes:
        value: of the function [m, rad or m³].
        gradient: (k, 3) its derivative by each point.
        curvature: (3 k, 3 k) its second derivative by the coordinates of the points, x, y, z of the first,
            then of the next; None: the function never gives it.
    """

    value: float
    gradient: Array
    curvature: Array | None = None


def transmitted_fault(found: object, k: int) -> str:
    """What is wrong with what a function of k points gives; "" where nothing is."""
    if not isinstance(found, Transmitted):
        return f"gives a {type(found).__name__}, expected is a Transmitted"
    parts = ("the value", found.value, ()), ("the gradient", found.gradient, (k, 3))
    if found.curvature is None:
        return shape_fault(*parts)
    return shape_fault(*parts, ("the curvature", found.curvature, (3 * k, 3 * k)))


class Transmission(Protocol):
    """A function of k points of a body."""

    def at(self, y: Array) -> Transmitted:
        """The function for positions y (k, 3) of its points [m]."""


@dataclass(frozen=True, slots=True)
class TransmissionSet(Generic[P_co]):
    """All transmissions of a robot, each over points of its own.

    Attributes:
        names: of the actuators.
        functions: of the points.
        starts: (t + 1,) where the points of each start among all of them.
        rest: (t,) values of the functions at rest.
        curved: (t,) which functions give their second derivatives.
        points: of all, of the type that the body has.
    """

    names: tuple[str, ...]
    functions: tuple[Transmission, ...]
    starts: Ints
    rest: Array
    curved: Bools
    points: P_co

    def __len__(self) -> int:
        return len(self.functions)

    def over(self, points: Q) -> TransmissionSet[Q]:
        """The same functions of points of another type."""
        return TransmissionSet(
            self.names, self.functions, self.starts, self.rest, self.curved, points
        )

    def at(self, y: Array) -> list[Transmitted]:
        """All functions at positions y (p, 3) of their points [m].

        Raises:
            ExtensionError: one fails, or gives something else than numbers of the right shapes.
        """
        parts = zip(self.names, self.functions, self.starts[:-1], self.starts[1:], strict=True)
        found = []
        for name, function, first, end in parts:
            fault = partial(transmitted_fault, k=int(end - first))
            found.append(answer_of(f"actuator {name!r}", fault, function.at, y[first:end]))
        return found

    def rows(self, motion: Motion[P_co]) -> Rows:
        """Positions δ and their derivative: Rows of (t, n)."""
        placed = motion.placed(self.points)
        found = self.at(placed.y)
        vectors = np.concatenate([one.gradient for one in found])
        H = placed.rows(Entries(self.starts, np.arange(len(vectors)), vectors))
        return Rows(H, np.array([one.value for one in found]) - self.rest)

    def vectors(self, y: Array, efforts: Array) -> Array:
        """Forces (p, 3) on points at y (p, 3) [m] under efforts (t,) [N]."""
        pairs = zip(efforts, self.at(y), strict=True)
        return np.concatenate([effort * one.gradient for effort, one in pairs])

    def segments(self, motion: Motion[P_co]) -> Array:
        """From the mean of the points of each to every one of them, for drawing: (p, 2, 3) [m]."""
        y, counts = motion.placed(self.points).y, np.diff(self.starts)
        means = np.add.reduceat(y, self.starts[:-1]) / counts[:, None]
        return np.stack([np.repeat(means, counts, axis=0), y], axis=1)

    @property
    def segment_owners(self) -> Ints:
        """The transmission of each segment: (p,)."""
        return np.repeat(np.arange(len(self)), np.diff(self.starts))

    def coupled(self, nodes: Ints) -> list[Ints]:
        """Groups (1, s) of nodes that second derivatives couple, of the nodes (p, k) of all points."""
        parts = zip(self.starts[:-1], self.starts[1:], self.curved, strict=True)
        return [np.unique(nodes[first:end])[None] for first, end, curved in parts if curved]

    def stiffness(self, motion: Motion[P_co], efforts: Array) -> Array:
        """What efforts (t,) add to a dense tangent, −Σ λ ∂²f/∂q²: (n, n)."""
        total = np.zeros((motion.n, motion.n))
        for moved, bend in self._bends(motion, efforts):
            J = dense(moved)
            total += J.T @ bend @ J
        return total

    def add_stiffness(
        self, motion: Motion[P_co], efforts: Array, pattern: Pattern, K: Array
    ) -> None:
        """Add what efforts do to a sparse tangent.

        Args:
            motion: of the body.
            efforts: (t,) [N, N m, Pa].
            pattern: in which the nodes of `coupled` are coupled.
            K: (nnz,) CSC values of −∂force, added to.
        """
        for moved, bend in self._bends(motion, efforts):
            assert not isinstance(moved, np.ndarray)
            columns = np.unique(moved.indices).astype(np.int64)
            J = moved[:, columns].toarray()
            pattern.add_block(K, columns, J.T @ bend @ J)

    def _bends(self, motion: Motion[P_co], efforts: Array) -> Iterator[tuple[Jacobian, Array]]:
        """Of each effort that bends anything, the motion of the points (3 k, n) and −λ ∂²f/∂y² (3 k, 3 k)."""
        placed = motion.placed(self.points)
        moved = placed.motion()
        for i, one in enumerate(self.at(placed.y)):
            if self.curved[i] and efforts[i] != 0.0 and one.curvature is not None:
                first, end = 3 * self.starts[i], 3 * self.starts[i + 1]
                yield moved[first:end], -efforts[i] * one.curvature


def second_derivative(gradient: Callable[[Array], Array], y: Array) -> Array:
    """The second derivative (3 k, 3 k) of a function of points y (k, 3) [m], by differences; symmetric.

    Central differences take 6 k times the gradient of the function, (k, 3) at positions (k, 3). Of a smooth
    function about eight digits are right.
    """
    step = _STEP * max(float(np.ptp(y, axis=0).max()), _CLOSE)
    columns = []
    for change in step * np.eye(y.size):
        by = change.reshape(y.shape)
        columns.append((gradient(y + by) - gradient(y - by)).ravel() / (2.0 * step))
    found = np.array(columns)
    bend: Array = 0.5 * (found + found.T)
    return bend


def make_transmissions(
    names: tuple[str, ...],
    functions: list[Transmission],
    counts: list[int],
    y0: Array,
    points: P,
) -> TransmissionSet[P]:
    """Transmissions at rest.

    Args:
        names: of the actuators.
        functions: of each, at least one.
        counts: points of each.
        y0: (p, 3) all of them at rest [m].
        points: of the type that the body has.
    """
    starts = np.cumsum([0, *counts]).astype(np.int64)
    none = np.zeros(len(functions))
    unbent = none.astype(np.bool_)
    still = TransmissionSet(names, tuple(functions), starts, none, unbent, points)
    found = still.at(y0)
    rest = np.array([one.value for one in found])
    curved = np.array([one.curvature is not None for one in found], np.bool_)
    return replace(still, rest=rest, curved=curved)
