"""Effectors of a robot file on a mesh or on beams."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from tauten.model.actuators import ChamberError, bulging
from tauten.model.effectors import (
    DistanceMeasure,
    Effectors,
    FrameMeasure,
    LengthMeasure,
    Measure,
    PositionMeasure,
    VolumeMeasure,
    frame_coefficients,
    measurement_fault,
)
from tauten.model.extension_error import shape_fault
from tauten.model.load.actuators import faces_of, wall_of_cavity
from tauten.model.load.extensions import at_rest, made, required_extension
from tauten.model.load.places import BeamPlaces, MeshPlaces, Places, Positions
from tauten.model.mesh import NodeSelector
from tauten.model.numerics import Array, Ints, diameter
from tauten.model.points import (
    AttachedPoints,
    MeanPoints,
    NodePoints,
    join_attached_points,
    make_paths,
    mean_points,
)
from tauten.model.schema import EffectorSettings, RobotFileError
from tauten.model.signals import effector_layout

EFFECTORS = "tauten.effectors"
P = TypeVar("P", NodePoints, AttachedPoints)
Q = TypeVar("Q", MeanPoints, AttachedPoints)


def build_nodal_effectors(
    effectors: list[EffectorSettings], places: MeshPlaces, dof: Ints, n: int
) -> Effectors[MeanPoints]:
    """Effectors of a body whose configuration is the positions of nodes.

    Args:
        effectors: of the robot file.
        places: on the bodies of the robot.
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
        n: number of degrees of freedom.

    Raises:
        RobotFileError: a point outside of the mesh, an empty region, one that has no frame or no volume.
    """
    measures, coefficients = [], [sp.csr_array((0, len(places.nodes)))]
    for index, item in enumerate(effectors):
        measure, weights = _on_nodes(item, f"effectors.{index}", places)
        measures.append(measure)
        coefficients.append(weights)
    joined = sp.csr_array(sp.vstack(coefficients, format="csr"))
    points = mean_points(joined, dof, n)
    return _effectors(effectors, measures, np.asarray(joined @ places.nodes), places, points)


def _on_nodes(
    item: EffectorSettings, field: str, places: MeshPlaces
) -> tuple[Measure, sp.csr_array]:
    """An effector, and the coefficients (P, n_nodes) of its points."""
    nodes, bodies = places.nodes, places.bodies

    def spread(ids: Ints, weights: Array) -> sp.csr_array:
        place = (np.repeat(np.arange(len(weights)), len(ids)), np.tile(ids, len(weights)))
        found = sp.csr_array((weights.ravel(), place), shape=(len(weights), len(nodes)))
        found.eliminate_zeros()
        return found

    single = _of_points(item, field, places)
    if single is not None:
        measure, points = single
        row = np.repeat(np.arange(len(points)), points.nodes.shape[1])
        shape = (len(points), len(nodes))
        return measure, sp.csr_array(
            (points.weights.ravel(), (row, points.nodes.ravel())), shape=shape
        )
    if item.kind == "volume":
        measure, ids = _cavity(item, places, field)
        return measure, spread(ids, np.eye(len(ids)))
    what = f"{field}.region"
    if item.region is None:
        raise RobotFileError(f"{places.source}: {what}: needed by a frame of a body of tetrahedra")
    ids = np.flatnonzero(places.select_nodes(item.region, what))
    if item.kind == "centre":
        return PositionMeasure(), spread(ids, np.full((1, len(ids)), 1.0 / len(ids)))
    centre, ids = nodes[ids].mean(axis=0), bodies.rigid_nodes(ids)
    try:
        weights = frame_coefficients(nodes[ids])
    except ValueError as error:
        raise RobotFileError(f"{places.source}: {what}: {error}") from error
    origin = np.array(item.point or centre) - nodes[ids].mean(axis=0)
    return FrameMeasure(origin), spread(ids, weights)


def _of_points(item: EffectorSettings, field: str, places: Places[P]) -> tuple[Measure, P] | None:
    """An effector that is given by points, and these; None: it is another one."""
    source = f"{places.source}: {field}"
    if item.points is not None:
        measure: Measure = (
            length_measure(item.points, item.pull_point)
            if item.kind == "length"
            else function_measure(item, source)
        )
        return measure, places.attach(item.points, f"{source}.points", item.max_outside)
    if item.kind not in ("point", "distance") or item.point is None:
        return None
    found = places.attach([item.point], f"{source}.point", item.max_outside)
    if item.other is None:
        return PositionMeasure(), found
    other = places.attach([item.other], f"{source}.other", item.max_outside)
    return DistanceMeasure(), places.join([found, other])


def _cavity(item: EffectorSettings, places: MeshPlaces, what: str) -> tuple[VolumeMeasure, Ints]:
    """The volume of a cavity over the nodes (P,) of its wall."""
    selector = places.bodies.selector
    try:
        wall = wall_of_cavity(item.inside, item.region, selector, f"{what}.region")
    except ChamberError as error:
        raise RobotFileError(f"{selector.source}: {what}: {error}") from error
    triangles, weights = bulging(wall, faces_of(wall, places))
    ids, corners = np.unique(triangles, return_inverse=True)
    return VolumeMeasure(corners.reshape(-1, 3), len(ids), weights), ids


def length_measure(
    points: Positions, pull_point: tuple[float, float, float] | None
) -> LengthMeasure:
    """The length of a cable through points, from a fixed one where there is one."""
    fixed = np.array([] if pull_point is None else [pull_point], dtype=float).reshape(-1, 3)
    path = make_paths([len(fixed) + len(points)], np.concatenate([fixed, np.array(points)]))
    return LengthMeasure(path, fixed, len(points))


def function_measure(item: EffectorSettings, what: str) -> Measure:
    """A function of points that another package computes.

    Raises:
        RobotFileError: no package has the function, or it does not give a number with its derivative.
    """
    assert item.measure is not None and item.points is not None
    make = required_extension(EFFECTORS, item.measure, f"{what}.measure")
    rest = np.array(item.points)
    measure: Measure = made(make, Measure, what, item.parameters or {}, rest)
    found = at_rest(measure.at, f"{what}.measure", rest.copy())
    carrier = shape_fault(("the carrier", measure.carrier, (len(rest),)))
    fault = measurement_fault(found, len(rest)) or carrier
    if fault:
        raise RobotFileError(f"{what}.measure: {item.measure!r} {fault}")
    parts = found.values, found.delta, found.position, found.gradient, measure.carrier
    if not all(np.isfinite(part).all() for part in parts):
        raise RobotFileError(f"{what}.measure: {item.measure!r} is not finite at rest")
    return measure


def build_beam_effectors(
    effectors: list[EffectorSettings], places: BeamPlaces
) -> Effectors[AttachedPoints]:
    """Effectors of a robot whose bodies are all made of beams.

    Raises:
        RobotFileError: a point that lies away from the beams, an empty region, a kind that beams do not have.
    """
    found = [_on_beams(item, f"effectors.{i}", places) for i, item in enumerate(effectors)]
    joined = join_attached_points([points for _, points in found])
    measures = [measure for measure, _ in found]
    return _effectors(effectors, measures, places.at_rest(joined), places, joined)


def _on_beams(
    item: EffectorSettings, field: str, places: BeamPlaces
) -> tuple[Measure, AttachedPoints]:
    """An effector, and its points."""
    single = _of_points(item, field, places)
    if single is not None:
        return single
    if item.kind == "volume":
        raise RobotFileError(f"{places.source}: {field}.kind: beams have no cavity, found 'volume'")
    if item.region is None:
        assert item.point is not None
        what = f"{places.source}: {field}.point"
        return FrameMeasure(np.zeros(3)), _node_frame(
            places.attach([item.point], what, item.max_outside)
        )
    ids = np.flatnonzero(places.select_nodes(item.region, f"{field}.region"))
    if item.kind == "centre":
        return PositionMeasure(len(ids)), places.at_nodes(ids)
    points = places.corners(ids)
    rest = places.at_rest(points)
    origin = np.array(item.point or places.nodes[ids].mean(axis=0)) - rest.mean(axis=0)
    return FrameMeasure(origin, frame_coefficients(rest)), points


def _node_frame(origin: AttachedPoints) -> AttachedPoints:
    """The points of the frame of one node: its origin, and the node's axes as differences of two points."""
    node = origin.nodes[0, 0]
    axes = AttachedPoints(
        np.full((3, 2), node),
        np.tile([1.0, -1.0], (3, 1)),
        np.stack([np.eye(3), np.zeros((3, 3))], axis=1),
    )
    return join_attached_points([origin, axes])


def _effectors(
    effectors: list[EffectorSettings],
    measures: list[Measure],
    y: Array,
    selector: NodeSelector,
    points: Q,
) -> Effectors[Q]:
    """Effectors over points that are at y (P, 3) at rest."""
    source, size = selector.source, diameter(selector.nodes)
    starts = np.cumsum([0, *(len(measure.carrier) for measure in measures)])
    at_rest = [
        measure.at(y[first:end]).values
        for measure, first, end in zip(measures, starts[:-1], starts[1:], strict=True)
    ]
    volumes = {}
    for index, (item, values) in enumerate(zip(effectors, at_rest, strict=True)):
        if item.kind == "distance" and not values[0] > 0.0:
            raise RobotFileError(f"{source}: effectors.{index}.other: coincides with point")
        if item.kind == "volume":
            volumes[item.name] = float(values[0])
    layout = effector_layout(effectors, size, volumes)
    return Effectors(layout, tuple(measures), starts, points)
