"""Actuators of a robot file, on the mesh of its body."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from tauten.model.actuators import (
    ActuatorParts,
    ChamberError,
    ChamberSurface,
    PointForce,
    cavity_around,
    cavity_nearest,
    chamber_surface,
    coupling_of,
    inside_out,
)
from tauten.model.mesh import UNITS, MeshError, Selector, TetMesh, read_triangles
from tauten.model.numerics import Array, Ints
from tauten.model.points import Cable, CableSet, MaterialPoints, attach, make_cables
from tauten.model.schema import (
    ChamberSettings,
    Extrapolation,
    ForceSettings,
    RobotConfig,
    RobotFileError,
)
from tauten.model.tetra import BodyParts

log = logging.getLogger(__name__)


Points: TypeAlias = list[tuple[float, float, float]]
Place: TypeAlias = Callable[[Points, str, float], MaterialPoints]


def build_actuators(
    config: RobotConfig, body: BodyParts, selector: Selector, place: Place
) -> ActuatorParts:
    """All actuators of a robot file.

    Args:
        config: the robot file.
        body: with the mesh and the masses of its nodes.
        selector: of regions of the mesh.
        place: attaches points to the body, `place_points`.

    Raises:
        RobotFileError: a point outside the mesh, a chamber that is not closed, an empty region.
    """
    return ActuatorParts(
        cables=build_cables(config, body.mesh, selector.source, place),
        chambers=[build_chamber(item, selector, place) for item in config.chambers],
        forces=[build_force(item, body, selector, place) for item in config.forces],
        coupling=coupling_of(config),
    )


def build_chamber(item: ChamberSettings, selector: Selector, place: Place) -> ChamberSurface:
    """The closed surface of a chamber.

    Args:
        item: the chamber.
        selector: of regions of the mesh.
        place: attaches points to the body.

    Raises:
        RobotFileError: a surface that is not there, not closed or outside the mesh.
    """
    where = f"{selector.source}: chambers.{item.name}"
    try:
        if item.stl is None:
            return ChamberSurface(boundary_of(item, selector))
        points, triangles = read_triangles(selector.folder / item.stl)
        points = UNITS[item.stl_unit] * points
        note = turned_surface(item, points, triangles)
        if note:
            log.warning("%s.stl: %s", where, note)
        if not item.own_surface:
            centres = points[triangles].mean(axis=1)
            found = cavity_nearest(selector.nodes, selector.boundary, centres)
            return ChamberSurface(chamber_surface(selector.nodes, found))
        used, corners = np.unique(triangles, return_inverse=True)
        points, triangles = points[used], corners.reshape(-1, 3)
        if not note:  # `chamber_surface` takes normals into the chamber
            triangles = triangles[:, ::-1]
        outward = chamber_surface(points, triangles)
    except (ChamberError, MeshError) as error:
        raise RobotFileError(f"{where}: {error}") from error
    places = [(x, y, z) for x, y, z in points.tolist()]
    return ChamberSurface(outward, place(places, f"{where}.stl", item.max_outside))


def boundary_of(item: ChamberSettings, selector: Selector) -> Ints:
    """Boundary triangles (t, 3) around a chamber without a file, normals out of the chamber.

    Raises:
        ChamberError: they are not closed, or there is no cavity.
    """
    nodes, boundary = selector.nodes, selector.boundary
    if item.inside is not None:
        return chamber_surface(nodes, cavity_around(nodes, boundary, np.array(item.inside)))
    assert item.surface is not None
    chosen = selector.select_triangles(item.surface, f"chambers.{item.name}.surface")
    return chamber_surface(nodes, boundary[chosen])


def turned_surface(item: ChamberSettings, points: Array, triangles: Ints) -> str:
    """A sentence about an STL file that is inside out; "" about one that is not.

    Args:
        item: the chamber of the file.
        points: (p, 3) of the file.
        triangles: (t, 3) of the file.
    """
    if not inside_out(points, triangles):
        return ""
    return f"{item.stl} is inside out: its normals point into the chamber; it has been turned"


def build_force(
    item: ForceSettings, body: BodyParts, selector: Selector, place: Place
) -> PointForce:
    """A force at a point or spread over the nodes in a region by their mass.

    Args:
        item: the force.
        body: with the mesh and the masses of its nodes.
        selector: of regions of the mesh.
        place: attaches points to the body.
    """
    where = f"{selector.source}: forces.{item.name}"
    direction = np.array(item.direction) / np.linalg.norm(item.direction)
    if item.point is not None:
        point = place([item.point], f"{where}.point", item.max_outside)
        return PointForce(point.nodes[0], point.weights[0], direction)
    assert item.region is not None
    chosen = np.flatnonzero(selector.select_nodes(item.region, f"forces.{item.name}.region"))
    return PointForce(chosen, body.mass[chosen] / body.mass[chosen].sum(), direction)


def build_cables(config: RobotConfig, mesh: TetMesh, source: str, place: Place) -> CableSet:
    """Cables attached to the mesh.

    Args:
        config: the robot file.
        mesh: the body.
        source: the robot file's path, for errors.
        place: attaches points to the body.
    """
    cables = []
    for index, cable in enumerate(config.cables):
        what = f"{source}: cables.{index}.points"
        points = place(cable.points, what, cable.max_outside)
        pull_point = None if cable.pull_point is None else np.array(cable.pull_point)
        route = np.array(cable.points if pull_point is None else [pull_point, *cable.points])
        short = np.flatnonzero(np.linalg.norm(np.diff(route, axis=0), axis=1) < 1e-9)
        if len(short):
            raise RobotFileError(f"{what}: points {short[0]} and {short[0] + 1} coincide")
        cables.append(Cable(cable.name, points, pull_point))
    return make_cables(cables, mesh.nodes)


def place_points(
    mesh: TetMesh, extrapolate_from: Extrapolation, points: Points, what: str, slack: float
) -> MaterialPoints:
    """`attach`, with its error as a RobotFileError.

    Args:
        mesh: the body.
        extrapolate_from: what points outside the mesh are moved by.
        points: rest positions [m].
        what: the field they come from, for errors.
        slack: how far outside the body a point may lie [m].
    """
    try:
        return attach(mesh, np.array(points), what, slack, extrapolate_from)
    except ValueError as error:
        raise RobotFileError(str(error)) from error
