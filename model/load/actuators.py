"""Actuators of a robot file, on the mesh of its body."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tauten.model.actuators import (
    ActuatorParts,
    ChamberError,
    PointForce,
    cavity_around,
    cavity_nearest,
    chamber_surface,
    coupling_of,
)
from tauten.model.load.surfaces import select_surface
from tauten.model.mesh import UNITS, MeshError, TetMesh, boundary_triangles, in_box, read_triangles
from tauten.model.numerics import Ints
from tauten.model.points import Cable, CableSet, MaterialPoints, attach, make_cables
from tauten.model.schema import ChamberSettings, ForceSettings, RobotConfig, RobotFileError
from tauten.model.tetra import BodyParts


def build_actuators(config: RobotConfig, body: BodyParts, source: str) -> ActuatorParts:
    """All actuators of a robot file.

    Args:
        config: the robot file.
        body: with the mesh and the masses of its nodes.
        source: the robot file's path, for errors and for the files beside it.

    Raises:
        RobotFileError: a point outside the mesh, a chamber that is not closed, an empty region.
    """
    mesh = body.mesh
    boundary = boundary_triangles(mesh.tets) if config.chambers else np.zeros((0, 3), np.int64)
    return ActuatorParts(
        cables=build_cables(config, mesh, source),
        chambers=[build_chamber(item, config, mesh, boundary, source) for item in config.chambers],
        forces=[build_force(item, body, source) for item in config.forces],
        coupling=coupling_of(config),
    )


def build_chamber(
    item: ChamberSettings, config: RobotConfig, mesh: TetMesh, boundary: Ints, source: str
) -> Ints:
    """The closed surface of a chamber (t, 3), normals out of the chamber.

    Args:
        item: the chamber.
        config: the robot file.
        mesh: the body.
        boundary: (b, 3) its boundary triangles.
        source: the robot file's path, for errors and for the files beside it.
    """
    where = f"{source}: chambers.{item.name}"
    try:
        if item.inside is not None:
            chosen = cavity_around(mesh.nodes, boundary, np.array(item.inside))
        elif item.stl is not None:
            unit = UNITS[item.stl_unit or config.mesh.length_unit]
            points, triangles = read_triangles(Path(source).parent / item.stl)
            centres = unit * points[triangles].mean(axis=1)
            chosen = cavity_nearest(mesh.nodes, boundary, centres)
        else:
            known = {surface.name: surface for surface in config.surfaces}
            if item.surface not in known:
                raise ChamberError(
                    f"surface {item.surface!r} is not defined, known are "
                    f"{', '.join(sorted(known)) or 'none'}"
                )
            chosen = select_surface(known[item.surface], mesh, boundary, source)
        return chamber_surface(mesh.nodes, chosen)
    except (ChamberError, MeshError) as error:
        raise RobotFileError(f"{where}: {error}") from error


def build_force(item: ForceSettings, body: BodyParts, source: str) -> PointForce:
    """A force at a point or spread over the nodes in a region by their mass.

    Args:
        item: the force.
        body: with the mesh and the masses of its nodes.
        source: the robot file's path, for errors.
    """
    where, nodes = f"{source}: forces.{item.name}", body.mesh.nodes
    direction = np.array(item.direction) / np.linalg.norm(item.direction)
    if item.point is not None:
        place = place_points(body.mesh, [item.point], f"{where}.point", item.max_outside)
        return PointForce(place.nodes[0], place.weights[0], direction)
    assert item.region is not None
    chosen = np.flatnonzero(in_box(nodes, item.region))
    if len(chosen) == 0:
        raise RobotFileError(
            f"{where}.region: no node in {item.region.lower} to {item.region.upper}"
        )
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
