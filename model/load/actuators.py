"""Actuators of a robot file, on the mesh of its body."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from tauten.model.actuators import (
    ActuatorSet,
    ChamberError,
    ChamberSet,
    ChamberSurface,
    Coupling,
    TransmissionSet,
    cavity_around,
    cavity_nearest,
    chamber_surface,
    coupled_nodes,
    coupling_of,
    inside_out,
    make_chambers,
    make_forces,
    no_drives,
)
from tauten.model.load.places import MeshPlaces, Places
from tauten.model.load.transmissions import build_transmissions
from tauten.model.mesh import UNITS, MeshError, Selector, read_triangles
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
    RobotConfig,
    RobotFileError,
)
from tauten.model.tetra import BodyParts

log = logging.getLogger(__name__)


P = TypeVar("P")


@dataclass(frozen=True, slots=True)
class ActuatorParts:
    """The actuators of a body, before the degrees of freedom are known.

    Attributes:
        paths: of the cables.
        stations: points that they pass.
        chambers: cavities under pressure.
        directions: (f, 3) of the forces, unit vectors.
        pushed: (f, n_nodes) weights of the nodes in the point of each force.
        coupling: of these; None: there is none.
        transmissions: functions of points; None: there are none.
    """

    paths: Paths
    stations: NodePoints
    chambers: ChamberSet
    directions: Array
    pushed: sp.csr_array
    coupling: Coupling | None
    transmissions: TransmissionSet[NodePoints | MeanPoints] | None

    @property
    def groups(self) -> list[Ints]:
        """Groups of nodes (g, s) that the actuators couple."""
        found = coupled_nodes(self.paths, self.stations, self.chambers)
        if self.transmissions is not None:
            assert isinstance(self.transmissions.points, NodePoints)
            found += self.transmissions.coupled(self.transmissions.points.nodes)
        return found

    def placed(self, x0: Array, dof: Ints, n: int) -> ActuatorSet[NodePoints | MeanPoints]:
        """The actuators over the degrees of freedom, each driven alone and without drives.

        Args:
            x0: (n_nodes, 3) node positions at rest [m].
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        points = mean_points(self.pushed, dof, n)
        return ActuatorSet(
            paths=self.paths,
            stations=self.stations,
            chambers=self.chambers,
            walls=points_at(self.chambers.used),
            forces=make_forces(self.directions, [np.ones(1)] * len(self.directions), points.at(x0)),
            pushed=points,
            drives=no_drives(),
            coupling=self.coupling,
            transmissions=self.transmissions,
        )


def build_actuators(
    config: RobotConfig, body: BodyParts, selector: Selector, places: MeshPlaces
) -> ActuatorParts:
    """All actuators of a robot file but drives.

    Raises:
        RobotFileError: a point outside the mesh, a chamber that is not closed, an empty region.
    """
    x0 = body.mesh.nodes
    paths, stations = build_cables(config, places)
    surfaces = [build_chamber(item, selector, places) for item in config.chambers]
    weights = [pushed_nodes(item, body, selector, places) for item in config.forces]
    directions = np.array([item.direction for item in config.forces]).reshape(-1, 3)
    return ActuatorParts(
        paths=paths,
        stations=stations,
        chambers=make_chambers(surfaces, x0),
        directions=directions / np.linalg.norm(directions, axis=1, keepdims=True),
        pushed=sp.csr_array(np.array(weights).reshape(-1, len(x0))),
        coupling=coupling_of(config),
        transmissions=build_transmissions(config.transmissions, places),
    )


def build_chamber(item: ChamberSettings, selector: Selector, places: MeshPlaces) -> ChamberSurface:
    """The closed surface of a chamber.

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
    vertices = [(x, y, z) for x, y, z in points.tolist()]
    return ChamberSurface(outward, places.attach(vertices, f"{where}.stl", item.max_outside))


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


def pushed_nodes(
    item: ForceSettings, body: BodyParts, selector: Selector, places: MeshPlaces
) -> Array:
    """Weights (n_nodes,) of the nodes in the point of a force; in a region they are by mass."""
    weights = np.zeros(len(body.mesh.nodes))
    if item.point is not None:
        where = f"{selector.source}: forces.{item.name}.point"
        point = places.attach([item.point], where, item.max_outside)
        np.add.at(weights, point.nodes[0], point.weights[0])
        return weights
    assert item.region is not None
    chosen = np.flatnonzero(selector.select_nodes(item.region, f"forces.{item.name}.region"))
    weights[chosen] = body.mass[chosen] / body.mass[chosen].sum()
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
