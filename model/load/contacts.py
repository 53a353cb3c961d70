"""From the contact tables of a robot file to contact pairs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np

from tauten.model.contact import (
    ALARM_EDGES,
    EDGES_AWAY,
    SHAPES,
    WALL_ALARMS,
    ContactPair,
    ContactSet,
    Shape,
    mean_edge,
    neighbours_at_rest,
)
from tauten.model.load.extensions import extension, extension_names, made
from tauten.model.mesh import Selector, spread_points, triangle_areas, vertex_points
from tauten.model.numerics import Array, Ints
from tauten.model.schema import (
    ALARM_DISTANCE,
    ITSELF,
    ContactSettings,
    ObstacleSettings,
    RobotConfig,
    RobotFileError,
    RobotSettings,
)

CONTACT_SHAPES = "tauten.contact_shapes"
NO_TRIANGLES = np.zeros((0, 3), dtype=np.int64)


def build_contacts(config: RobotConfig, selector: Selector) -> ContactSet:
    """Candidates and target surfaces of every contact of a robot with meshes.

    Args:
        config: the robot file.
        selector: of regions of the mesh.

    Raises:
        RobotFileError: a surface without triangles or area.
    """
    surfaces = contact_surfaces(config, selector)
    return contact_set(config, selector.nodes, surfaces, selector.source)


def contact_set(
    config: RobotSettings, vertices: Array, surfaces: Mapping[str | None, Ints], source: str
) -> ContactSet:
    """Candidates and target surfaces of every contact.

    Args:
        config: the robot file.
        vertices: (v, 3) of the surfaces at rest [m].
        surfaces: triangles (t, 3) of each surface by name; None is all of them.
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: a surface without area, or an obstacle that is none.
    """
    alarm = alarm_distance(config, vertices, surfaces)
    targets: dict[str | None, Ints | Shape] = {
        **surfaces,
        **{one.name: build_obstacle(one, source) for one in config.obstacles},
    }
    pairs = [
        contact_pair(contact, f"{source}: contacts.{index}", vertices, targets, alarm)
        for index, contact in enumerate(config.contacts)
    ]
    return ContactSet(pairs, len(vertices), alarm, config.contact.distance)


def build_obstacle(item: ObstacleSettings, source: str) -> Shape:
    """The shape of an obstacle.

    Args:
        item: the table.
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: a shape that nobody has, or parameters that it does not take.
    """
    field = f"{source}: obstacles.{item.name}"
    make = SHAPES.get(item.shape) or extension(CONTACT_SHAPES, item.shape)
    if make is None:
        known = ", ".join([*SHAPES, *extension_names(CONTACT_SHAPES)])
        raise RobotFileError(f"{field}.shape: {item.shape!r} is unknown, found are {known}")
    shape: Shape = made(make, field, item.parameters)
    return shape


def check_shape(shape: Shape, points: Array, where: str) -> None:
    """Raise a RobotFileError where a shape does not give distances with their gradients.

    Args:
        shape: of a package.
        points: (m, 3) of the candidates at rest [m].
        where: file and name of the table, for errors.
    """
    gap, normal = shape.closest(points)
    m = len(points)
    if np.shape(gap) != (m,) or np.shape(normal) != (m, 3):
        raise RobotFileError(
            f"{where}.against: the shape gives distances and normals of the shapes {np.shape(gap)} and "
            f"{np.shape(normal)} for {m} points, expected are {(m,)} and {(m, 3)}"
        )
    if not np.isfinite(gap).all():
        raise RobotFileError(f"{where}.against: the shape gives distances that are not finite")
    off = np.abs(np.linalg.norm(normal, axis=1) - 1.0)
    if not off.max() < 1e-6:
        raise RobotFileError(
            f"{where}.against: the shape gives the normal {np.round(normal[off.argmax()], 6).tolist()} at "
            f"{np.round(points[off.argmax()], 6).tolist()} m, which must have the length 1"
        )


def contact_surfaces(config: RobotConfig, selector: Selector) -> dict[str | None, Ints]:
    """Triangles (t, 3) of each surface by name; None is the whole boundary.

    Args:
        config: the robot file.
        selector: of regions of the mesh.

    Raises:
        RobotFileError: the robot has no surface.
    """
    if config.contacts and len(selector.boundary) == 0:
        raise RobotFileError(
            f"{selector.source}: contacts: beams that are bodies are lines without a surface; attach bodies "
            "with meshes to them, or write a structure file, whose beams have surfaces"
        )
    obstacles = {one.name for one in config.obstacles}
    used = [name for contact in config.contacts for name in (contact.candidates, contact.against)]
    wanted = dict.fromkeys([*(surface.name for surface in config.surfaces), *used])
    surfaces: dict[str | None, Ints] = {None: selector.boundary}
    for name in wanted:
        if name is not None and name != ITSELF and name not in obstacles:
            chosen = selector.select_triangles(selector.named[name], f"surfaces.{name}")
            surfaces[name] = selector.boundary[chosen]
    return surfaces


def alarm_distance(
    config: RobotSettings, vertices: Array, surfaces: Mapping[str | None, Ints]
) -> float:
    """The file's, or by default from the meshes of the surfaces that may touch themselves [m].

    Args:
        config: the robot file.
        vertices: (v, 3) of the surfaces at rest [m].
        surfaces: triangles of each surface by name.
    """
    if config.contact.alarm_distance is not None:
        return config.contact.alarm_distance
    folded = [surfaces[item.candidates] for item in config.contacts if item.against == ITSELF]
    sizes = [ALARM_EDGES * mean_edge(vertices, triangles) for triangles in folded]
    return min(sizes, default=ALARM_DISTANCE) + config.contact.distance


def contact_pair(
    contact: ContactSettings,
    where: str,
    vertices: Array,
    targets: Mapping[str | None, Ints | Shape],
    alarm: float,
) -> ContactPair:
    """One contact.

    Args:
        contact: its table.
        where: file and name of the table, for errors.
        vertices: (v, 3) of the surfaces at rest [m].
        targets: triangles of each surface, and the obstacles, by name.
        alarm: the alarm distance [m].

    Raises:
        RobotFileError: a surface without area.
    """
    triangles = targets[contact.candidates]
    assert isinstance(triangles, np.ndarray)
    nodes, weights = candidates_on(vertices, triangles, contact.points, where)
    if contact.against != ITSELF:
        name = f"{contact.candidates or 'skin'} on {contact.against}"
        target = targets[contact.against]
        if isinstance(target, np.ndarray):
            return ContactPair(name, nodes, weights, target, friction=contact.friction)
        check_shape(target, np.einsum("mj,mji->mi", weights, vertices[nodes]), where)
        return ContactPair(
            name, nodes, weights, NO_TRIANGLES, shape=target, friction=contact.friction
        )
    edge = mean_edge(vertices, triangles)
    along = contact.neighbour_distance or max(EDGES_AWAY * edge, 2.0 * alarm)
    apart = neighbours_at_rest(vertices, triangles, nodes, weights, along, WALL_ALARMS * alarm)
    name = f"{contact.candidates or 'skin'} on itself"
    return ContactPair(name, nodes, weights, triangles, apart, friction=contact.friction)


def all_triangles(named: Mapping[str, Ints]) -> Ints:
    """Triangles (t, 3) of all surfaces of a structure file."""
    return np.concatenate([np.zeros((0, 3), np.int64), *named.values()])


def candidates_on(
    vertices: Array,
    triangles: Ints,
    points: int | Literal["vertices"] | None,
    where: str,
) -> tuple[Ints, Array]:
    """Vertices (m, 3) of the triangles that candidates lie in, and weights (m, 3).

    Args:
        vertices: (v, 3) at rest [m].
        triangles: (t, 3) of the surface.
        points: how many, one at each vertex, or one for each square of a mean edge.
        where: file and name of the table, for errors.

    Raises:
        RobotFileError: a surface without area.
    """
    if points is None:
        area = float(triangle_areas(vertices, triangles).sum())
        edge = mean_edge(vertices, triangles)
        points = max(1, round(area / edge**2)) if area > 0.0 else 1
    try:
        if points == "vertices":
            return vertex_points(triangles)
        return spread_points(vertices, triangles, points)
    except ValueError as error:
        raise RobotFileError(f"{where}: {error}") from error
