"""Transmissions of a robot file: motors that act through functions which other packages register."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from tauten.model.actuators import Transmission, TransmissionSet, make_transmissions
from tauten.model.load.extensions import made, required_extension
from tauten.model.mesh import NodeSelector, Selector
from tauten.model.numerics import Array, Ints
from tauten.model.points import (
    AttachedPoints,
    MaterialPoints,
    MeanPoints,
    NodePoints,
    attach_to_nodes,
    join_attached_points,
)
from tauten.model.schema import RobotFileError, TransmissionSettings

ACTUATORS = "tauten.actuators"
Positions = list[tuple[float, float, float]]
P = TypeVar("P")
Placing = Callable[[Positions, str, float], P]


def build_nodal_transmissions(
    items: Sequence[TransmissionSettings], selector: Selector, place: Placing[MaterialPoints]
) -> TransmissionSet[NodePoints | MeanPoints] | None:
    """Transmissions of a body whose configuration is the positions of nodes; None: there are none.

    Args:
        items: of the robot file.
        selector: of regions of the mesh.
        place: attaches points at rest [m] to the mesh; with the field they come from, for errors, and
            how far outside they may lie [m].

    Raises:
        RobotFileError: a point outside of the mesh, an empty region, a function that no package has or that
            does not give a number with its derivative.
    """

    def at_nodes(ids: Ints) -> MaterialPoints:
        weights = np.tile([1.0, 0.0, 0.0, 0.0], (len(ids), 1))
        return MaterialPoints(np.repeat(ids[:, None], 4, axis=1), weights)

    found = [
        _arguments(item, f"transmissions.{item.name}", selector, place, at_nodes) for item in items
    ]
    if not found:
        return None
    nodes = np.concatenate([part.nodes for part in found])
    weights = np.concatenate([part.weights for part in found])
    points = NodePoints(nodes, weights, np.zeros((len(nodes), 3)))
    counts, y0 = [len(part) for part in found], points.at(selector.nodes)
    return make_transmissions(_functions(items, counts, y0, selector.source), counts, y0, points)


def build_beam_transmissions(
    items: Sequence[TransmissionSettings], selector: NodeSelector, attach: Placing[AttachedPoints]
) -> TransmissionSet[AttachedPoints] | None:
    """Transmissions of a body made of beams, each point of which moves with one node; None: there are none.

    Args:
        items: of the robot file.
        selector: of regions of the nodes.
        attach: attaches points at rest [m] to nodes; arguments as of `build_nodal_transmissions`.

    Raises:
        RobotFileError: as `build_nodal_transmissions`.
    """
    nodes = selector.nodes

    def at_nodes(ids: Ints) -> AttachedPoints:
        return attach_to_nodes(nodes, ids, nodes[ids])

    found = [
        _arguments(item, f"transmissions.{item.name}", selector, attach, at_nodes) for item in items
    ]
    if not found:
        return None
    points, counts = join_attached_points(found), [len(part) for part in found]
    y0 = points.at_rest(nodes)
    return make_transmissions(_functions(items, counts, y0, selector.source), counts, y0, points)


def _arguments(
    item: TransmissionSettings,
    field: str,
    selector: NodeSelector,
    place: Placing[P],
    at_nodes: Callable[[Ints], P],
) -> P:
    """The points of a transmission."""
    if item.points is not None:
        return place(item.points, f"{selector.source}: {field}.points", item.max_outside)
    assert item.region is not None
    return at_nodes(np.flatnonzero(selector.select_nodes(item.region, f"{field}.region")))


def _functions(
    items: Sequence[TransmissionSettings], counts: list[int], y0: Array, source: str
) -> list[Transmission]:
    """The functions of transmissions whose points are y0 (p, 3) at rest [m], counted in turn."""
    places = np.split(y0, np.cumsum(counts[:-1]))
    return [
        transmission(item, f"{source}: transmissions.{item.name}", y)
        for item, y in zip(items, places, strict=True)
    ]


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
    function: Transmission = made(make, what, item.parameters, rest)
    found, k = function.at(rest.copy()), len(rest)
    shapes, expected = [np.shape(found.value), np.shape(found.gradient)], [(), (k, 3)]
    if found.curvature is not None:
        shapes.append(np.shape(found.curvature))
        expected.append((3 * k, 3 * k))
    if shapes != expected:
        raise RobotFileError(
            f"{what}.function: {item.function!r} gives value, gradient and curvature of the shapes {shapes}, "
            f"expected are {expected}"
        )
    if not (np.isfinite(found.value) and np.isfinite(found.gradient).all()):
        raise RobotFileError(f"{what}.function: {item.function!r} is not finite at rest")
    return function
