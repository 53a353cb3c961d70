"""A robot that is pressed by spheres: what pushes on surfaces which touch something that is not in its file.

An obstacle that a robot file names pushes in every campaign. What the file does not name, because a robot of
which this one is a part has it, is here spheres of several sizes, which stand in the way of surfaces: the
actuators drive these against the spheres, and the forces are those that the actuators can exert.

The robot gets an effector of kind point at some places of the surfaces too, so that their positions are
compared between full and reduced models. State bases made with it fit the robot without them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tauten.model import Robot, static_compliance
from tauten.model.contact import ObstaclePoses, pose_at
from tauten.model.load import load_part
from tauten.model.mesh import spread_points, unit_normals
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.schema import RobotConfig, RobotFileError, read_toml
from tauten.reduction.campaign.command_range import CommandRange
from tauten.reduction.campaign.snapshots import Snapshots

WHOLE = "skin"  # instead of the name of a surface: all of it
PLACES = 30  # at most, on all surfaces, unless another number is asked for
RADII = (0.5, 0.25, 0.125, 0.0625)  # of the spheres, of the size of the robot
FRICTION = 0.5  # between sphere and robot
FARTHEST = 0.25  # how far an actuator alone moves a place, of the size of the robot, to first order
IN_THE_WAY = 0.5  # of the way of a place at most, until it touches
MOST = 2  # spheres that touch at the same time
AWAY = 100.0  # sizes of the robot, where spheres are that press nothing
PREFIX = "sphere_of_campaign_"


@dataclass(frozen=True, slots=True, eq=False)
class TouchedRobot:
    """A robot with spheres, and an effector at each of some places of its surfaces that touch.

    Attributes:
        robot: its own effectors, obstacles and contacts come first.
        plain: the robot without them.
        surfaces: names of the surfaces.
        places: (m, 3) at rest [m].
        normals: (m, 3) outwards.
        vertices: (v, 3) of the surfaces at rest [m].
        radii: (k,) of the spheres [m].
    """

    robot: Robot
    plain: Robot
    surfaces: tuple[str, ...]
    places: Array
    normals: Array
    vertices: Array
    radii: Array

    @property
    def own(self) -> int:
        """Number of effectors of the plain robot."""
        return len(self.plain.effector_names)

    @property
    def away(self) -> Array:
        """Centres of the spheres where they press nothing: (3 k,) [m]."""
        return np.tile([0.0, 0.0, -AWAY * self.robot.size], len(self.radii))


def touched_robot(
    path: Path, surfaces: Sequence[str] | None = None, most: int = PLACES
) -> TouchedRobot | None:
    """The robot of a file with spheres, and places on its surfaces that touch.

    Args:
        path: the robot file.
        surfaces: names of surfaces or regions, `WHOLE` for all of it; None: `touching_surfaces`.
        most: places at most.

    Returns:
        None where none does, and for a robot of parts.

    Raises:
        RobotFileError, MeshError: the file cannot be used, or a surface is unknown.
    """
    contents = read_toml(path)
    if "parts" in contents:
        return None
    part = load_part(contents, path)
    names = touching_surfaces(part.file) if surfaces is None else tuple(surfaces)
    if not names:
        return None
    robot = part.robot
    named = [None if name == WHOLE else name for name in names]
    triangles = part.surface(named[0])  # in their order places are where candidates are
    if len(named) > 1:
        triangles = np.unique(np.concatenate([part.surface(name) for name in named]), axis=0)
    ids, corners = np.unique(triangles, return_inverse=True)
    x = robot.motion(robot.rest()).placed(robot.body.surface_points(ids)).y  # (v, 3)
    where = f"{path}: surfaces {', '.join(names)}"
    places, normals = _places(x, corners.reshape(-1, 3), min(most, len(x)), where)
    radii = robot.size * np.array(RADII)
    points = [  # those of beams lie beside their nodes
        {"name": f"place{i}", "point": place.tolist(), "max_outside": robot.size}
        for i, place in enumerate(places)
    ]
    spheres = [
        {
            "name": f"{PREFIX}{i}",
            "shape": "sphere",
            "parameters": {"centre": [0.0, 0.0, 0.0], "radius": radius},
            "position": [0.0, 0.0, -AWAY * robot.size],
        }
        for i, radius in enumerate(radii.tolist())
    ]
    contacts = [
        {"against": sphere["name"], "points": "vertices", "friction": FRICTION}
        | ({} if name is None else {"candidates": name})
        for sphere in spheres
        for name in named
    ]
    added = {"effectors": points, "obstacles": spheres, "contacts": contacts}
    more = {key: [*contents.get(key, []), *tables] for key, tables in added.items()}
    pressed = load_part(contents | more, path).robot
    return TouchedRobot(pressed, robot, names, places, normals, x, radii)


def touching_surfaces(file: RobotConfig) -> tuple[str, ...]:
    """The surfaces of a robot file that touch obstacles, and those that no contact of the file names.

    The latter are there for robots that the file is a part of.
    """
    obstacles = {one.name for one in file.obstacles}
    outside = [one.candidates or WHOLE for one in file.contacts if one.against in obstacles]
    named = [one.name for one in file.surfaces]
    used = {name for one in file.contacts for name in (one.candidates, one.against)}
    return tuple(dict.fromkeys([*outside, *(name for name in named if name not in used)]))


def _places(vertices: Array, triangles: Ints, count: int, where: str) -> tuple[Array, Array]:
    """Places (m, 3) spread over a surface (v, 3), (t, 3) [m], and its normals there (m, 3)."""
    try:
        nodes, weights = spread_points(vertices, triangles, count)
    except ValueError as error:
        raise RobotFileError(f"{where}: {error}") from error
    corners = vertices[nodes]  # (m, 3, 3)
    return np.einsum("mj,mji->mi", weights, corners), unit_normals(corners)


def pressing_runs(
    touched: TouchedRobot, found: CommandRange, ends: Array, seed: int
) -> tuple[Array, Array]:
    """Smaller ends (runs, n_a) of runs, and centres (runs, 3 k) of spheres that stand in their way [m].

    Args:
        touched: the robot.
        found: range of each actuator.
        ends: (runs, n_a) shares of the ranges at the end of runs.
        seed: of the random numbers.
    """
    rng = np.random.default_rng(seed)
    ways = _ways(touched, found)  # (3 m, n_a)
    m = len(touched.places)
    reach = np.linalg.norm(ways.reshape(m, 3, -1), axis=1).max(axis=0)  # (n_a,)
    most = FARTHEST * touched.robot.size
    ends = ends * np.minimum(1.0, most / np.maximum(reach, 1e-9 * most))
    centres = np.stack([_in_the_way(touched, ways @ end, rng) for end in ends])
    return ends, centres


def _in_the_way(touched: TouchedRobot, way: Array, rng: np.random.Generator) -> Array:
    """Centres (3 k,) of spheres [m], some of which stand in the way of places."""
    places, normals, radii = touched.places, touched.normals, touched.radii
    outwards = np.maximum((way.reshape(-1, 3) * normals).sum(axis=1), 0.0)  # (m,)
    chance = outwards + 1e-6 * touched.robot.size
    centres = touched.away.reshape(-1, 3)
    free = list(range(len(radii)))
    for _ in range(1 + rng.integers(MOST)):
        place = int(rng.choice(len(places), p=chance / chance.sum()))
        gap = IN_THE_WAY * rng.uniform() * outwards[place]
        for sphere in rng.permutation(free).tolist():
            centre = places[place] + (radii[sphere] + gap) * normals[place]
            if np.linalg.norm(touched.vertices - centre, axis=1).min() >= radii[sphere]:
                centres[sphere] = centre
                free.remove(sphere)
                break
    return centres.ravel()


def _ways(touched: TouchedRobot, found: CommandRange) -> Array:
    """How the places move, to first order at rest, when each actuator alone goes to its end: (3 m, n_a)."""
    robot = touched.robot
    rows = robot.rows(robot.rest(), contacts=False)
    first = robot.effector_layout.row_starts[touched.own]
    H = np.vstack([rows.effectors.dense()[first:], rows.actuators.dense()])
    W = static_compliance(robot, H)
    n = 3 * len(touched.places)
    softness = np.where(found.by_force, 1.0, np.diag(W)[n:])
    ways: Array = W[:n, n:] * (found.most / softness)
    return ways


def pressed_by(obstacles: ObstaclePoses, centres: Array) -> ObstaclePoses:
    """The obstacles of a robot with its last k ones, spheres, at centres (3 k,) [m]."""
    names = obstacles.names[len(obstacles.names) - len(centres) // 3 :]
    for name, centre in zip(names, centres.reshape(-1, 3), strict=True):
        obstacles = obstacles.with_pose(name, pose_at(centre))
    return obstacles


def pressed_columns(robot: Robot, snapshots: Snapshots) -> Bools:
    """Which snapshots have a sphere in the way of the robot, whether it touches or not: (s,)."""
    near = snapshots.pressed[2::3] > -0.5 * AWAY * robot.size  # (k, s)
    found: Bools = np.any(near, axis=0)
    return found


def of_plain_robot(touched: TouchedRobot, snapshots: Snapshots) -> Snapshots:
    """The snapshots in which no sphere is in the way, as those of the plain robot."""
    free = snapshots.select(~pressed_columns(touched.robot, snapshots))
    rows, slots = 3 * touched.own, touched.plain.n_c
    return replace(
        free,
        lam=free.lam[:slots],
        effector=free.effector[:rows],
        effector_force=free.effector_force[:rows],
        pressed=free.pressed[:0],
    )
