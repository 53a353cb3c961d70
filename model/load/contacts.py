"""From the contact tables of a robot file to contact pairs."""

from __future__ import annotations

from collections.abc import Mapping

from tauten.model.contact import (
    ALARM_EDGES,
    EDGES_AWAY,
    WALL_ALARMS,
    ContactPair,
    ContactSet,
    mean_edge,
    neighbours_at_rest,
)
from tauten.model.mesh import Selector, spread_points, triangle_areas, vertex_points
from tauten.model.numerics import Array, Ints
from tauten.model.schema import (
    ALARM_DISTANCE,
    ITSELF,
    ContactSettings,
    RobotConfig,
    RobotFileError,
    RobotSettings,
)


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
        RobotFileError: a surface without area.
    """
    alarm = alarm_distance(config, vertices, surfaces)
    pairs = [
        contact_pair(contact, f"{source}: contacts.{index}", vertices, surfaces, alarm)
        for index, contact in enumerate(config.contacts)
    ]
    return ContactSet(pairs, len(vertices), alarm, config.contact.distance)


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
    used = [name for contact in config.contacts for name in (contact.candidates, contact.against)]
    wanted = dict.fromkeys([*(surface.name for surface in config.surfaces), *used])
    surfaces: dict[str | None, Ints] = {None: selector.boundary}
    for name in wanted:
        if name is not None and name != ITSELF:
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
    surfaces: Mapping[str | None, Ints],
    alarm: float,
) -> ContactPair:
    """One contact.

    Args:
        contact: its table.
        where: file and name of the table, for errors.
        vertices: (v, 3) of the surfaces at rest [m].
        surfaces: triangles of each surface by name.
        alarm: the alarm distance [m].

    Raises:
        RobotFileError: a surface without area.
    """
    triangles = surfaces[contact.candidates]
    edge = mean_edge(vertices, triangles)
    points = contact.points
    if points is None:
        area = float(triangle_areas(vertices, triangles).sum())
        points = max(1, round(area / edge**2)) if area > 0.0 else 1
    try:
        nodes, weights = (
            vertex_points(triangles)
            if points == "vertices"
            else spread_points(vertices, triangles, points)
        )
    except ValueError as error:
        raise RobotFileError(f"{where}: {error}") from error
    if contact.against != ITSELF:
        name = f"{contact.candidates} on {contact.against}"
        return ContactPair(name, nodes, weights, surfaces[contact.against])
    along = contact.neighbour_distance or max(EDGES_AWAY * edge, 2.0 * alarm)
    apart = neighbours_at_rest(vertices, triangles, nodes, weights, along, WALL_ALARMS * alarm)
    name = f"{contact.candidates or 'skin'} on itself"
    return ContactPair(name, nodes, weights, triangles, apart)
