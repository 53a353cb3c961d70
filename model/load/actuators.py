"""Actuators of a robot file, on the mesh of its body."""

from __future__ import annotations

import logging
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from tauten.model.actuators import (
    ActuatorSet,
    ChamberError,
    ChamberSurface,
    cavity_around,
    cavity_nearest,
    chamber_surface,
    coupling_of,
    inside_out,
    make_chambers,
    make_forces,
    no_drives,
)
from tauten.model.load.places import MeshPlaces, Places
from tauten.model.load.transmissions import build_transmissions
from tauten.model.mesh import UNITS, MeshError, Selector, quadratic_faces, read_triangles
from tauten.model.numerics import Array, Ints
from tauten.model.points import (
    MeanPoints,
    NodePoints,
    Paths,
    make_paths,
    mean_points,
    points_at,
)
from tauten.model.schema import (
    ChamberSettings,
    ForceSettings,
    Region,
    RobotConfig,
    RobotFileError,
)

log = logging.getLogger(__name__)
QUADRATIC = (4, 10)  # points of quadrature and nodes of quadratic tetrahedra

P = TypeVar("P")


def build_actuators(
    config: RobotConfig, places: MeshPlaces, dof: Ints
) -> ActuatorSet[NodePoints | MeanPoints]:
    """All actuators of a robot file but drives.

    Args:
        config: the robot file.
        places: on its bodies.
        dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.

    Raises:
        RobotFileError: a point outside the mesh, a chamber that is not closed, an empty region.
    """
    x0 = places.nodes
    paths, stations = build_cables(config, places)
    chambers = make_chambers([build_chamber(item, places) for item in config.chambers], x0)
    weights = [pushed_nodes(item, places) for item in config.forces]
    directions = np.array([item.direction for item in config.forces]).reshape(-1, 3)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    pushed_weights = sp.csr_array(np.array(weights).reshape(-1, len(x0)))
    pushed = mean_points(pushed_weights, dof, 3 * int((dof >= 0).sum()))
    return ActuatorSet(
        paths=paths,
        stations=stations,
        chambers=chambers,
        walls=points_at(chambers.used),
        forces=make_forces(directions, [np.ones(1)] * len(directions), pushed.at(x0)),
        pushed=pushed,
        drives=no_drives(),
        coupling=coupling_of(config),
        transmissions=build_transmissions(config.transmissions, places),
    )


def build_chamber(item: ChamberSettings, places: MeshPlaces) -> ChamberSurface:
    """The closed surface of a chamber.

    Raises:
        RobotFileError: a surface that is not there, not closed or outside the mesh.
    """
    selector, where = places.bodies.selector, f"{places.source}: chambers.{item.name}"
    try:
        if item.stl is None:
            what = f"chambers.{item.name}.surface"
            wall = wall_of_cavity(item.inside, item.surface, selector, what)
            return ChamberSurface(wall, faces=faces_of(wall, places))
        points, triangles = read_triangles(selector.folder / item.stl)
        points = UNITS[item.stl_unit] * points
        turned = inside_out(points, triangles)
        if turned:
            log.warning(
                "%s.stl: %s is inside out: its normals point into the chamber; it has been turned",
                where,
                item.stl,
            )
        if not item.own_surface:
            centres = points[triangles].mean(axis=1)
            found = cavity_nearest(selector.nodes, selector.boundary, centres)
            wall = chamber_surface(selector.nodes, found)
            return ChamberSurface(wall, faces=faces_of(wall, places))
        used, corners = np.unique(triangles, return_inverse=True)
        points, triangles = points[used], corners.reshape(-1, 3)
        if not turned:  # `chamber_surface` takes normals into the chamber
            triangles = triangles[:, ::-1]
        outward = chamber_surface(points, triangles)
    except (ChamberError, MeshError) as error:
        raise RobotFileError(f"{where}: {error}") from error
    vertices = [(x, y, z) for x, y, z in points.tolist()]
    return ChamberSurface(outward, places.attach(vertices, f"{where}.stl", item.max_outside))


def faces_of(wall: Ints, places: MeshPlaces) -> Ints:
    """Corners (f, 3) of the faces of quadratic elements that boundary triangles (t, 3) are four parts of."""
    domains = places.bodies.parts.domains
    tets = [one.nodes for one in domains if one.gradients.shape[1:3] == QUADRATIC]
    return quadratic_faces(wall, np.concatenate([np.zeros((0, 10), np.int64), *tets]))


def wall_of_cavity(
    inside: tuple[float, float, float] | None,
    wall: Region | str | None,
    selector: Selector,
    what: str,
) -> Ints:
    """Boundary triangles (t, 3) around a cavity, normals out of it.

    Args:
        inside: a point in it [m]; None: `wall` says where it is.
        wall: the region of these triangles, or its name.
        selector: of regions.
        what: the field of the region, for errors.

    Raises:
        ChamberError: they are not closed, or there is no cavity.
    """
    nodes, boundary = selector.nodes, selector.boundary
    if inside is not None:
        return chamber_surface(nodes, cavity_around(nodes, boundary, np.array(inside)))
    assert wall is not None
    return chamber_surface(nodes, boundary[selector.select_triangles(wall, what)])


def pushed_nodes(item: ForceSettings, places: MeshPlaces) -> Array:
    """Weights (n_nodes,) of the nodes in the point of a force; in a region they are by mass."""
    weights, mass = np.zeros(len(places.nodes)), places.bodies.parts.mass
    if item.point is not None:
        where = f"{places.source}: forces.{item.name}.point"
        point = places.attach([item.point], where, item.max_outside)
        np.add.at(weights, point.nodes[0], point.weights[0])
        return weights
    assert item.region is not None
    chosen = np.flatnonzero(places.select_nodes(item.region, f"forces.{item.name}.region"))
    weights[chosen] = mass[chosen] / mass[chosen].sum()
    return weights


def build_cables(config: RobotConfig, places: Places[P]) -> tuple[Paths, P]:
    """Cables, and the points that they pass."""
    stations: list[P] = []
    counts = []
    for index, cable in enumerate(config.cables):
        what = f"{places.source}: cables.{index}.points"
        start = () if cable.pull_point is None else (cable.pull_point,)
        stations += [places.held(start), places.attach(cable.points, what, cable.max_outside)]
        route = np.array([*start, *cable.points])
        short = np.flatnonzero(np.linalg.norm(np.diff(route, axis=0), axis=1) < 1e-9)
        if len(short):
            raise RobotFileError(f"{what}: points {short[0]} and {short[0] + 1} coincide")
        counts.append(len(route))
    joined = places.join(stations)
    return make_paths(counts, places.at_rest(joined)), joined
