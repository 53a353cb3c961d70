"""Effectors as functions of a few points: values, and how they change when the points move.

A point here is any linear combination of nodes, of beams any combination of points attached to nodes: the
points of a frame are a mean and moments (`tauten.model.effectors.frame`). So one implementation serves
full, reduced and beam robots, which differ in how points follow from the configuration.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tauten.model.actuators import volumes
from tauten.model.extension_error import shape_fault
from tauten.model.numerics import Array, Ints
from tauten.model.points import Paths, path_lengths


@dataclass(frozen=True, slots=True)
class Measurement:
    """An effector at some positions of its points.

    Attributes:
        values: (v,) goal values.
        delta: (m,) values of its rows.
        position: (3,) where it is drawn [m].
        gradient: (m, P, 3) change of the rows when the points move.
    """

    values: Array
    delta: Array
    position: Array
    gradient: Array


def measurement_fault(found: object, P: int) -> str:
    """What is wrong with what a function of P points gives; "" where nothing is."""
    if not isinstance(found, Measurement):
        return f"gives a {type(found).__name__}, expected is a Measurement"
    return shape_fault(
        ("the values", found.values, (1,)),
        ("delta", found.delta, (1,)),
        ("the position", found.position, (3,)),
        ("the gradient", found.gradient, (1, P, 3)),
    )


class Measure(Protocol):
    """One effector as a function of its points."""

    @property
    def carrier(self) -> Array:
        """Weights (P,) of its points in the place where outer forces act on it."""

    def at(self, y: Array) -> Measurement:
        """The effector for positions y (P, 3) of its points."""


@dataclass(frozen=True, slots=True)
class PositionMeasure:
    """The mean of its points: an effector of kind point or centre.

    Attributes:
        count: number of points, P.
    """

    count: int = 1

    @property
    def carrier(self) -> Array:
        """Weights (P,) of its points in the place where outer forces act on it."""
        return np.full(self.count, 1.0 / self.count)

    def at(self, y: Array) -> Measurement:
        """The effector for positions y (P, 3) of its points."""
        mean = y.mean(axis=0)
        gradient = np.broadcast_to(np.eye(3)[:, None, :] / self.count, (3, self.count, 3))
        return Measurement(mean, mean, mean, gradient)


@dataclass(frozen=True, slots=True)
class DistanceMeasure:
    """The distance between two points; where they coincide its derivative is taken as zero."""

    @property
    def carrier(self) -> Array:
        """Weights (2,) of its points in the place where outer forces act on it."""
        return np.full(2, 0.5)

    def at(self, y: Array) -> Measurement:
        """The effector for positions y (2, 3) of its points."""
        d = y[1] - y[0]
        length = float(np.linalg.norm(d))
        e = d / length if length > 0.0 else np.zeros(3)
        value = np.array([length])
        return Measurement(value, value, y.mean(axis=0), np.stack([-e, e])[None])


@dataclass(frozen=True, slots=True)
class LengthMeasure:
    """The length of a passive cable through its points.

    Attributes:
        path: through all stations.
        fixed: (f, 3) the first station where it lies outside of the body, none or one [m].
        count: number of points, P.
    """

    path: Paths
    fixed: Array
    count: int

    @property
    def carrier(self) -> Array:
        """Weights (P,) of its points in the place where outer forces act on it."""
        return np.full(self.count, 1.0 / self.count)

    def at(self, y: Array) -> Measurement:
        """The effector for positions y (P, 3) of its points."""
        stations = np.concatenate([self.fixed, y])
        length, shorter = path_lengths(stations, self.path.starts, self.path.shortest)
        return Measurement(length, length, y.mean(axis=0), -shorter[None, len(self.fixed) :])


@dataclass(frozen=True, slots=True)
class VolumeMeasure:
    """The volume of a cavity.

    Attributes:
        triangles: (t, 3) its wall by number of the point, normals out of the cavity.
        count: number of points, P.
        weights: (t,) of each triangle in its corners, see `tauten.model.actuators.bulging`.
    """

    triangles: Ints
    count: int
    weights: Array

    @property
    def carrier(self) -> Array:
        """Weights (P,) of its points in the place where outer forces act on it."""
        return np.full(self.count, 1.0 / self.count)

    def at(self, y: Array) -> Measurement:
        """The effector for positions y (P, 3) of its points."""
        mean = y.mean(axis=0)
        one = np.zeros(len(self.triangles), dtype=np.int64)
        surface = (self.triangles, np.repeat(self.weights[:, None], 3, axis=1))
        # relative to the mean, which changes no closed volume: products of large coordinates cancel
        found, gradient = volumes(y - mean, one, surface, self.triangles, self.count)
        return Measurement(found[:1], found[:1], mean, gradient[None])
