"""What contacts say before a robot moves: walls, overlaps at rest, free bodies that nothing touches."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tauten.model import Robot
from tauten.model.actuators import winding
from tauten.model.contact import ContactPair
from tauten.model.load import Bodies
from tauten.model.mesh import boundary_triangles, distances_to_triangles, wall_thickness
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.schema import PartsConfig, RobotConfig
from tauten.service.check.findings import Finding

WALLS = "walls that may touch"  # subject of a finding
INSIDE = 0.5  # of a turn that a surface winds around a point


def contact_finding(robot: Robot, bodies: Bodies, tolerance: float) -> Finding:
    """What overlaps at rest, else the thickness of the walls behind the contacts.

    Args:
        robot: the robot.
        bodies: of its file.
        tolerance: overlap that is none [m].
    """
    found = [one for one in overlaps(robot, bodies) if one[0] > tolerance]
    if not found:
        return thin_walls(robot, robot.contacts.alarm_distance)
    depth, pair, other, at = max(found, key=lambda one: one[0])
    where = ", ".join(f"{value:.4g}" for value in at)
    return Finding(
        WALLS,
        "wrong" if depth > robot.contacts.alarm_distance else "doubtful",
        f"at rest a candidate of {pair} is {1e3 * depth:.3g} mm inside {other}, at ({where}) m",
        f"move one of them apart: contact presses on what overlaps from the start, or, deeper than the alarm "
        f"distance of {1e3 * robot.contacts.alarm_distance:g} mm, does not find it",
    )


def overlaps(robot: Robot, bodies: Bodies) -> Iterator[tuple[float, str, str, Array]]:
    """How deep candidates of each contact are in other bodies at rest; what is in obstacles is refused.

    Yields:
        the depth of the deepest [m], the name of the contact, that of the body it is in, and where (3,) [m].
    """
    contacts = robot.contacts
    points = contacts.positions(robot.motion(robot.rest()).placed(robot.vertices).y)
    for pair, slots in zip(contacts.pairs, contacts.pair_slots, strict=True):
        for name, depth, at in in_bodies(bodies, pair, points[slots.first : slots.end]):
            yield depth, pair.name, name, at


def in_bodies(
    bodies: Bodies, pair: ContactPair, points: Array
) -> Iterator[tuple[str, float, Array]]:
    """The bodies of a contact's target that candidates of other bodies are in.

    Args:
        bodies: of the robot.
        pair: the contact.
        points: (m, 3) where its candidates are [m].

    Yields:
        the name of the body, the depth of the deepest candidate [m], and where it is (3,) [m].
    """
    mesh = bodies.parts.mesh
    solid = mesh.tets[~bodies.of_beams(mesh)]
    for name in bodies.selector.ranges:
        nodes = bodies.selector.nodes_of(name)
        wall = boundary_triangles(solid[nodes[solid[:, 0]]])
        if len(wall) and belongs(nodes, pair.triangles[:, 0]).any():
            others = points[~belongs(nodes, pair.nodes[:, 0])]
            inside = others[within(mesh.nodes, wall, others)]
            if len(inside):
                depths = distances_to_triangles(inside, mesh.nodes[wall])
                yield name, float(depths.max()), inside[depths.argmax()]


def belongs(nodes: Bools, vertices: Ints) -> Bools:
    """Which vertices (m,) are among chosen nodes (n_nodes,); those beyond them are of outlines of beams."""
    chosen: Bools = np.zeros(len(vertices), np.bool_)
    known = vertices < len(nodes)
    chosen[known] = nodes[vertices[known]]
    return chosen


def within(x: Array, wall: Ints, points: Array) -> Bools:
    """Which points lie in a body: (m,).

    Args:
        x: (n_nodes, 3) node positions [m].
        wall: (t, 3) boundary triangles of the body.
        points: (m, 3) [m].
    """
    corners = x[wall].reshape(-1, 3)
    inside: Bools = ((points > corners.min(axis=0)) & (points < corners.max(axis=0))).all(axis=1)
    for number in np.flatnonzero(inside):
        inside[number] = winding(x, wall, points[number]) > INSIDE
    return inside


def untouched(robot: Robot, bodies: Bodies, config: RobotConfig) -> tuple[str, ...]:
    """Names of the free bodies with a mesh that no contact of a file touches; attached ones are left out."""
    if config.attachments:
        return ()
    surfaces = [which for pair in robot.contacts.pairs for which in (pair.nodes, pair.triangles)]
    touched = np.concatenate([np.zeros(0, np.int64), *(which.ravel() for which in surfaces)])
    free = [body.name for body in config.bodies if body.free and body.mesh is not None]
    return tuple(
        name for name in free if not belongs(bodies.selector.nodes_of(name), touched).any()
    )


def idle_obstacles(config: RobotConfig | PartsConfig) -> Iterator[Finding]:
    """Obstacles that no contact of a file names."""
    touched = [contact.against for contact in config.contacts]
    idle = [one.name for one in config.obstacles if one.name not in touched]
    if idle:
        yield Finding(
            "obstacles",
            "doubtful",
            f"{', '.join(idle)}: named by no contact of the robot file, the robot goes through",
            f'[[contacts]] with against = "{idle[0]}"',
        )


def thin_walls(robot: Robot, alarm_distance: float) -> Finding:
    """Thickness of the body behind the surfaces that may touch, against the alarm distance.

    A thin wall is wrong where a contact has both of its sides, and fine where it has one of them: then no
    candidate finds the other side.
    """
    pairs = robot.contacts.pairs
    if not pairs:
        return Finding(WALLS, "fine", "no contacts in the robot file")
    if not any(len(pair.triangles) for pair in pairs):
        return Finding(WALLS, "fine", "all contacts are with obstacles")
    nodes, drawn = robot.motion(robot.rest()).placed(robot.vertices).y, robot.triangles
    boundary = drawn[(drawn < len(nodes)).all(axis=1)]  # outlines of beams are no walls
    triangles = np.unique(np.concatenate([pair.triangles for pair in pairs]), axis=0)
    thickness = wall_thickness(nodes, boundary, triangles)  # (t,)
    thin = int((thickness < alarm_distance).sum())
    at = int(thickness.argmin())
    found = (
        f"{1e3 * thickness[at]:.3g} mm at least, at ({place_of(nodes, triangles[at])}) m; {thin} of "
        f"{len(triangles)} triangles thinner than the alarm distance of {1e3 * alarm_distance:g} mm"
    )
    name, least, where = min((to_other_side(nodes, pair) for pair in pairs), key=lambda one: one[1])
    if least < alarm_distance:
        found += f"; {name} has both sides of a wall of {1e3 * least:.3g} mm, at ({where}) m"
        advice = (
            f"set contact.alarm_distance below {least:.2g} m, or leave one side out of the contact"
        )
        return Finding(WALLS, "wrong", found, advice)
    if thin:
        found += ", and no contact has both sides of one"
    return Finding(WALLS, "fine", found)


def to_other_side(nodes: Array, pair: ContactPair) -> tuple[str, float, str]:
    """The thinnest wall that has both of its sides in a contact, between vertices (v, 3) at rest [m].

    Returns:
        the name of the contact, the thickness of the wall, inf where there is none [m], and where it is.
    """
    if len(pair.triangles) == 0:
        return pair.name, np.inf, ""
    sides = np.unique(np.concatenate([pair.nodes, pair.triangles]), axis=0)
    thickness = wall_thickness(nodes, pair.triangles, sides)  # (s,)
    at = int(thickness.argmin())
    return pair.name, float(thickness[at]), place_of(nodes, sides[at])


def place_of(nodes: Array, triangle: Ints) -> str:
    """The centre of a triangle (3,) of vertices (v, 3) [m], in words."""
    return ", ".join(f"{value:.4g}" for value in nodes[triangle].mean(axis=0))
