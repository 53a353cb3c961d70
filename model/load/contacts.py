"""From the contact tables of a robot file to contact pairs."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from tauten.model.actuators import winding
from tauten.model.contact import (
    ALARM_EDGES,
    EDGES_AWAY,
    SHAPES,
    WALL_ALARMS,
    ContactPair,
    ContactSet,
    ForceBounds,
    Obstacle,
    ObstaclePath,
    ObstaclePose,
    PlaneShape,
    PoseStream,
    Shape,
    distances_fault,
    heights_of_file,
    holes_before_obstacles,
    holes_between,
    largest_sums,
    loose_bodies,
    mean_edge,
    mesh_of_file,
    neighbours_at_rest,
    pose_at,
)
from tauten.model.load.extensions import at_rest, extension, extension_names, made
from tauten.model.mesh import (
    Selector,
    covering_points,
    spread_points,
    triangle_areas,
    vertex_points,
)
from tauten.model.numerics import Array, Ints
from tauten.model.schema import (
    ALARM_DISTANCE,
    ITSELF,
    ContactSettings,
    ObstacleSettings,
    PartContactSettings,
    RobotConfig,
    RobotFileError,
    RotationSettings,
    TouchSettings,
)

log = logging.getLogger(__name__)

CONTACT_SHAPES = "tauten.contact_shapes"
FROM_FILES: dict[str, Callable[..., Shape]] = {
    "mesh": mesh_of_file,
    "height-field": heights_of_file,
}
CHECKED = 50  # points of an obstacle, about
NO_TRIANGLES = np.zeros((0, 3), dtype=np.int64)


def contact_set(
    config: RobotConfig,
    vertices: Array,
    surfaces: Mapping[str | None, Ints],
    joined: Ints,
    source: str,
) -> ContactSet:
    """Candidates and target surfaces of every contact.

    Args:
        config: the robot file.
        vertices: (v, 3) of the surfaces at rest [m].
        surfaces: triangles (t, 3) of each surface by name; None is all of them.
        joined: (v,) number of the bodies that elasticity, beams or glue join, that each vertex belongs to.
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: a surface without area, or whose triangles are not oriented alike, or an obstacle
            that is none.
    """
    alarm = alarm_distance(config, vertices, surfaces)
    obstacles = [build_obstacle(one, source) for one in config.obstacles]
    targets: dict[str | None, Ints | Obstacle] = {
        **surfaces,
        **{one.name: one for one in obstacles},
    }
    pairs = [
        contact_pair(
            contact,
            f"{source}: contacts.{index}",
            vertices,
            targets,
            alarm,
            config.contact.tolerance,
            joined,
        )
        for index, contact in enumerate(config.contacts)
    ]
    for one in obstacles:
        check_outside(one, vertices, surfaces[None], f"{source}: obstacles.{one.name}")
    of_files = zip(pairs, config.contacts, strict=True)
    touching = [(pair, surfaces[one.candidates]) for pair, one in of_files]
    between = holes_between(touching, vertices, joined)
    for note in (*between, *holes_before_obstacles(touching, vertices)):
        log.warning("%s: %s", source, note)
    sums = largest_sums(pairs, config.contact.max_force)
    try:
        return ContactSet(pairs, len(vertices), alarm, config.contact.distance, sums)
    except ValueError as error:
        raise RobotFileError(f"{source}: {error}") from error


def force_bounds(contact: TouchSettings) -> ForceBounds:
    """What decisions keep of the forces of a contact."""
    largest = np.inf if contact.max_force is None else contact.max_force
    return ForceBounds(contact.min_force, largest, contact.min_slip_margin)


def build_obstacle(item: ObstacleSettings, source: str) -> Obstacle:
    """An obstacle.

    Raises:
        RobotFileError: a shape that nobody has, or parameters that it does not take.
    """
    path = stream = None
    if item.path is not None:
        times = np.array([one.time for one in item.path.waypoints])
        poses = tuple(frame_pose(one.position, one.rotation) for one in item.path.waypoints)
        path = ObstaclePath(times, poses, item.path.loop)
    if item.stream is not None:
        spin = float(np.radians(item.stream.largest_spin_deg))
        stream = PoseStream(item.stream.largest_speed, spin, item.stream.timeout)
    pose = frame_pose(item.position, item.rotation)
    largest = np.inf if item.max_force is None else item.max_force
    return Obstacle(item.name, build_shape(item, source), pose, path, stream, largest)


def build_shape(item: ObstacleSettings, source: str) -> Shape:
    """The shape of an obstacle, see `build_obstacle`."""
    field = f"{source}: obstacles.{item.name}"
    make = extension(CONTACT_SHAPES, item.shape, {**SHAPES, **FROM_FILES})
    if make is None:
        known = ", ".join([*SHAPES, *FROM_FILES, *extension_names(CONTACT_SHAPES)])
        raise RobotFileError(f"{field}.shape: {item.shape!r} is unknown, found are {known}")
    folder = (Path(source).parent,) if item.shape in FROM_FILES else ()
    shape: Shape = made(make, Shape, field, item.parameters, *folder)
    return shape


def frame_pose(
    position: tuple[float, float, float], rotation: RotationSettings | None
) -> ObstaclePose:
    """A pose at standstill of a position [m] and a rotation of a robot file."""
    quaternion = None if rotation is None else np.array(rotation.unit_quaternion)
    return pose_at(np.array(position), quaternion)


def check_obstacle(obstacle: Obstacle, points: Array, depth: float, where: str) -> None:
    """Raise a RobotFileError where a shape gives no distances with their gradients, or is in the robot.

    Args:
        obstacle: whose shape may be of a package.
        points: (m, 3) of the candidates at rest [m].
        depth: that is accepted [m].
        where: file and name of the table, for errors.
    """
    start, m = obstacle.start, len(points)

    own = (points - start.position) @ start.Q
    found = at_rest(obstacle.shape.closest, f"{where}.against: the shape", own)
    fault = distances_fault(found, m)
    if fault:
        raise RobotFileError(f"{where}.against: the shape {fault}")
    gap, normal = found
    if not np.isfinite(gap).all():
        raise RobotFileError(f"{where}.against: the shape gives distances that are not finite")
    off = np.abs(np.linalg.norm(normal, axis=1) - 1.0)
    if not off.max() < 1e-6:
        raise RobotFileError(
            f"{where}.against: the shape gives the normal {np.round(normal[off.argmax()], 6).tolist()} at "
            f"{np.round(points[off.argmax()], 6).tolist()} m, which must have the length 1"
        )
    if gap.min() < -depth:
        deepest = np.round(points[gap.argmin()], 6).tolist()
        raise RobotFileError(
            f"{where}.against: the obstacle {obstacle.name!r} is in the robot at rest: the surface is "
            f"{-1e3 * gap.min():.3g} mm deep in it at {deepest} m, allowed is contact.tolerance, "
            f"{1e3 * depth:.3g} mm; move the obstacle"
        )


def check_outside(obstacle: Obstacle, vertices: Array, triangles: Ints, where: str) -> None:
    """Raise a RobotFileError where an obstacle is within the material, out of reach of all candidates.

    Args:
        obstacle: in its place at the start; one that says not how it is drawn is not checked.
        vertices: (v, 3) of the robot's surface at rest [m].
        triangles: (t, 3) of all of it.
        where: file and name of the table, for errors.
    """
    if len(triangles) == 0 or isinstance(obstacle.shape, PlaneShape):
        return
    start = obstacle.start
    outline, _ = obstacle.outline(start, start.position, 0.0)
    chosen = outline[:: max(1, len(outline) // CHECKED)] @ start.Q.T + start.position
    low, high = vertices[triangles].min(axis=(0, 1)), vertices[triangles].max(axis=(0, 1))
    for point in chosen[((chosen > low) & (chosen < high)).all(axis=1)]:
        if winding(vertices, triangles, point) > 0.5:
            raise RobotFileError(
                f"{where}: the obstacle is in the robot at rest: {np.round(point, 6).tolist()} m of its "
                "surface lies in the material; move the obstacle"
            )


def contact_surfaces(config: RobotConfig, selector: Selector) -> dict[str | None, Ints]:
    """Triangles (t, 3) of each surface by name; None is the whole boundary."""
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
    config: RobotConfig, vertices: Array, surfaces: Mapping[str | None, Ints]
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
    targets: Mapping[str | None, Ints | Obstacle],
    alarm: float,
    tolerance: float,
    body: Ints,
) -> ContactPair:
    """One contact.

    Args:
        contact: its table.
        where: file and name of the table, for errors.
        vertices: (v, 3) of the surfaces at rest [m].
        targets: triangles of each surface, and the obstacles, by name.
        alarm: the alarm distance [m].
        tolerance: depth of obstacles in the surfaces at rest that is accepted [m].
        body: (v,) number of the body that each vertex belongs to.

    Raises:
        RobotFileError: a surface without area, or an obstacle within the robot.
    """
    triangles = targets[contact.candidates]
    assert isinstance(triangles, np.ndarray)
    nodes, weights = candidates_on(vertices, triangles, contact, where)
    made = partial(
        ContactPair, contact.name, nodes, weights,
        friction=contact.friction, bounds=force_bounds(contact),
    )  # fmt: skip
    if contact.against != ITSELF:
        target = targets[contact.against]
        if isinstance(target, np.ndarray):
            return made(target, loose=loose_bodies(body, nodes, target))
        pair = made(NO_TRIANGLES, obstacle=target)
        check_obstacle(target, pair.candidates(vertices), tolerance, where)
        return pair
    edge = mean_edge(vertices, triangles)
    along = contact.neighbour_distance or max(EDGES_AWAY * edge, 2.0 * alarm)
    apart = neighbours_at_rest(vertices, triangles, nodes, weights, along, WALL_ALARMS * alarm)
    return made(triangles, apart, loose=loose_bodies(body, nodes, triangles))


def candidates_on(
    vertices: Array,
    triangles: Ints,
    contact: ContactSettings | PartContactSettings,
    where: str,
) -> tuple[Ints, Array]:
    """Vertices (m, 3) of the triangles that candidates lie in, and weights (m, 3).

    Args:
        vertices: (v, 3) at rest [m].
        triangles: (t, 3) of the surface.
        contact: how many, one at each vertex, one for each square of a mean edge, or how far apart.
        where: file and name of the table, for errors.

    Raises:
        RobotFileError: a surface without area.
    """
    points = contact.points
    try:
        if points == "vertices":
            return vertex_points(triangles)
        if contact.spacing is not None:
            return covering_points(vertices, triangles, contact.spacing)
        if points is None:
            area = float(triangle_areas(vertices, triangles).sum())
            edge = mean_edge(vertices, triangles)
            points = max(1, round(area / edge**2)) if area > 0.0 else 1
        return spread_points(vertices, triangles, points)
    except ValueError as error:
        raise RobotFileError(f"{where}: {error}") from error
