"""Transmissions of a robot file: motors that act through functions which other packages register."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from tauten.model.actuators import (
    Transmission,
    TransmissionSet,
    make_transmissions,
    transmitted_fault,
)
from tauten.model.load.extensions import at_rest, made, required_extension
from tauten.model.load.places import Places
from tauten.model.numerics import Array
from tauten.model.points import AttachedPoints, NodePoints
from tauten.model.schema import RobotFileError, TransmissionSettings

ACTUATORS = "tauten.actuators"
P = TypeVar("P", NodePoints, AttachedPoints)


def build_transmissions(
    items: Sequence[TransmissionSettings], places: Places[P]
) -> TransmissionSet[P] | None:
    """Transmissions of a robot; None: there are none.

    Raises:
        RobotFileError: a point outside of the bodies, an empty region, a function that no package has or that
            does not give a number with its derivative.
    """
    found = [_arguments(item, f"transmissions.{item.name}", places) for item in items]
    if not found:
        return None
    points, counts = places.join(found), [len(part) for part in found]
    y0 = places.at_rest(points)
    names = tuple(item.name for item in items)
    functions = [
        transmission(item, f"{places.source}: transmissions.{item.name}", y)
        for item, y in zip(items, np.split(y0, np.cumsum(counts[:-1])), strict=True)
    ]
    return make_transmissions(names, functions, counts, y0, points)


def _arguments(item: TransmissionSettings, field: str, places: Places[P]) -> P:
    """The points of a transmission."""
    if item.points is not None:
        return places.attach(item.points, f"{places.source}: {field}.points", item.max_outside)
    assert item.region is not None
    return places.at_nodes(np.flatnonzero(places.select_nodes(item.region, f"{field}.region")))


def transmission(item: TransmissionSettings, what: str, rest: Array) -> Transmission:
    """A function of points that another package computes.

    Args:
        item: the table.
        what: where it is, for errors.
        rest: (k, 3) the points at rest [m].

    Raises:
        RobotFileError: no package has the function, or it does not give a number with its derivative.
    """
    make = required_extension(ACTUATORS, item.function, f"{what}.function")
    function: Transmission = made(make, Transmission, what, item.parameters, rest)
    found = at_rest(function.at, f"{what}.function", rest.copy())
    fault = transmitted_fault(found, len(rest))
    if fault:
        raise RobotFileError(f"{what}.function: {item.function!r} {fault}")
    parts = found.value, found.gradient, 0.0 if found.curvature is None else found.curvature
    if not all(np.isfinite(part).all() for part in parts):
        raise RobotFileError(f"{what}.function: {item.function!r} is not finite at rest")
    return function
