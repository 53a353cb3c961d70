"""Actuators of a robot file, on the mesh of its body."""

from __future__ import annotations

import logging

import numpy as np

from tauten.model.actuators import (
    ActuatorParts,
    ChamberError,
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
from tauten.model.schema import ChamberSettings, ForceSettings, RobotConfig, RobotFileError
from tauten.model.tetra import BodyParts

log = logging.getLogger(__name__)


def build_actuators(config: RobotConfig, body: BodyParts, selector: Selector) -> ActuatorParts:
    """All actuators of a robot file.

    Args:
        config: the robot file.
        body: with the mesh and the masses of its nodes.
        selector: of regions of the mesh.

    Raises:
        RobotFileError: a point outside the mesh, a chamber that is not closed, an empty region.
    """
    mesh, source = body.mesh, selector.source
    return ActuatorParts(
        cables=build_cables(config, mesh, source),
        chambers=[build_chamber(item, selector) for item in config.chambers],
        forces=[build_force(item, body, selector) for item in config.forces],
        coupling=coupling_of(config),
    )


def build_chamber(item: ChamberSettings, selector: Selector) -> Ints:
    """The closed surface of a chamber (t, 3), normals out of the chamber.

    Args:
        item: the chamber.
        selector: of regions of the mesh.
    """
    nodes, boundary, source = selector.nodes, selector.boundary, selector.source
    where = f"{source}: chambers.{item.name}"
    try:
        if item.inside is not None:
            chosen = cavity_around(nodes, boundary, np.array(item.inside))
        elif item.stl is not None:
            unit = UNITS[item.stl_unit]
            points, triangles = read_triangles(selector.folder / item.stl)
            note = turned_surface(item, points, triangles)
            if note:
                log.warning("%s.stl: %s", where, note)
            centres = unit * points[triangles].mean(axis=1)
            chosen = cavity_nearest(nodes, boundary, centres)
        else:
            assert item.surface is not None
            what = f"chambers.{item.name}.surface"
            chosen = boundary[selector.select_triangles(item.surface, what)]
        return chamber_surface(nodes, chosen)
    except (ChamberError, MeshError) as error:
        raise RobotFileError(f"{where}: {error}") from error


def turned_surface(item: ChamberSettings, points: Array, triangles: Ints) -> str:
    """A sentence about an STL file that is inside out; "" about one that is not.

    Args:
        item: the chamber of the file.
        points: (p, 3) of the file.
        triangles: (t, 3) of the file.
    """
    if not inside_out(points, triangles):
        return ""
    return (
        f"{item.stl} is inside out: its normals point into the chamber; it has been turned, because the "
        "orientation of the body counts"
    )


def build_force(item: ForceSettings, body: BodyParts, selector: Selector) -> PointForce:
    """A force at a point or spread over the nodes in a region by their mass.

    Args:
        item: the force.
        body: with the mesh and the masses of its nodes.
        selector: of regions of the mesh.
    """
    where = f"{selector.source}: forces.{item.name}"
    direction = np.array(item.direction) / np.linalg.norm(item.direction)
    if item.point is not None:
        place = place_points(body.mesh, [item.point], f"{where}.point", item.max_outside)
        return PointForce(place.nodes[0], place.weights[0], direction)
    assert item.region is not None
    chosen = np.flatnonzero(selector.select_nodes(item.region, f"forces.{item.name}.region"))
    return PointForce(chosen, body.mass[chosen] / body.mass[chosen].sum(), direction)


def build_cables(config: RobotConfig, mesh: TetMesh, source: str) -> CableSet:
    """Cables attached to the mesh.

    Args:
        config: the robot file.
        mesh: the body.
        source: the robot file's path, for errors.
    """
    cables = []
    for index, cable in enumerate(config.cables):
        what = f"{source}: cables.{index}.points"
        points = place_points(mesh, cable.points, what, cable.max_outside)
        pull_point = None if cable.pull_point is None else np.array(cable.pull_point)
        route = np.array(cable.points if pull_point is None else [pull_point, *cable.points])
        short = np.flatnonzero(np.linalg.norm(np.diff(route, axis=0), axis=1) < 1e-9)
        if len(short):
            raise RobotFileError(f"{what}: points {short[0]} and {short[0] + 1} coincide")
        cables.append(Cable(cable.name, points, pull_point))
    return make_cables(cables, mesh.nodes)


def place_points(
    mesh: TetMesh, points: list[tuple[float, float, float]], what: str, slack: float
) -> MaterialPoints:
    """`attach`, with its error as a RobotFileError.

    Args:
        mesh: the body.
        points: rest positions [m].
        what: the field they come from, for errors.
        slack: how far outside the body a point may lie [m].
    """
    try:
        return attach(mesh, np.array(points), what, slack)
    except ValueError as error:
        raise RobotFileError(str(error)) from error
