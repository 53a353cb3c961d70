"""From a robot file with parts to one robot of them."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

from tauten.model.contact import (
    ContactPair,
    ContactSet,
    MeshShape,
    holes_before_obstacles,
    holes_between,
)
from tauten.model.load.contacts import (
    NO_TRIANGLES,
    build_obstacle,
    candidates_on,
    check_obstacle,
    force_bounds,
)
from tauten.model.mesh import Selector
from tauten.model.numerics import Array, Ints
from tauten.model.parts import Assembly, Between, Part, PartsBody, Placement, join_parts
from tauten.model.robot import Robot
from tauten.model.schema import (
    ALARM_DISTANCE,
    ContactRange,
    PartsConfig,
    PartSurfaceSettings,
    RobotConfig,
    RobotFileError,
    parts_digest,
)

log = logging.getLogger(__name__)

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class LoadedPart:
    """A robot, and the surfaces that its file names.

    Attributes:
        robot: the robot.
        surface: triangles (t, 3) of a surface by name, None for the whole one; it raises a RobotFileError
            where there is no such surface.
        file: its robot file, as it is without others.
    """

    robot: Robot
    surface: Callable[[str | None], Ints]
    file: RobotConfig


Read = Callable[[str], LoadedPart]  # by the file of a part


def build_parts(config: PartsConfig, read: Read, source: str) -> Robot[PartsBody]:
    """One robot of several parts.

    Raises:
        RobotFileError, MeshError: a part cannot be used, or a surface is unknown.
    """
    gravity = np.array(config.gravity)
    places = [Placement.of(part.rotation, part.position) for part in config.parts]
    loaded = [read(part.robot) for part in config.parts]
    for note in unused_fields(config, loaded, places):
        log.warning("%s: %s", source, note)
    robots = [
        one.robot.fork().loaded(
            place.into_part(gravity), np.zeros(3 * len(one.robot.effector_names))
        )
        for one, place in zip(loaded, places, strict=True)
    ]
    parts = [
        Part(one.name, robot, place)
        for one, robot, place in zip(config.parts, robots, places, strict=True)
    ]
    check_driven(parts, source)
    own = [robot.contacts for robot in robots]
    tolerance = smallest_tolerance(config.contact, robots)
    between = contact_between(config, parts, loaded, tolerance, source)
    assembly = Assembly(
        name=config.name,
        frame=config.frame,
        digest=digest_of(config, parts, between, source),
        gravity=gravity,
        tolerance=tolerance,
        alarm_distance=config.contact.alarm_distance
        or common_alarm(own, config.contact.distance, source),
        distance=common_distance(own, config.contact.distance, source),
        max_force=config.contact.max_force,
        between=between,
        couplings=config.couplings,
    )
    try:
        return join_parts(assembly, parts)
    except ValueError as error:
        raise RobotFileError(f"{source}: {error}") from error


def unused_fields(
    config: PartsConfig, loaded: Sequence[LoadedPart], places: Sequence[Placement]
) -> Iterator[str]:
    """What files of parts say otherwise than the file of all parts, which does not say it but counts.

    Gravity that is the same in the frame of the part or of the robot is not otherwise.
    """
    used = np.array(config.gravity)
    for part, one, place in zip(config.parts, loaded, places, strict=True):
        own, given = one.file, one.file.model_fields_set
        alike = any(np.allclose(own.gravity, g) for g in (used, place.into_part(used)))
        if "gravity" in given and "gravity" not in config.model_fields_set and not alike:
            yield (
                f"parts.{part.name}: gravity {list(own.gravity)} in {part.robot} is not used; write it into "
                f"this file, whose gravity of all parts is {list(config.gravity)} by default"
            )
        rates = config.controller.rate, own.controller.rate
        if "rate" not in config.controller.model_fields_set and rates[0] != rates[1]:
            yield (
                f"parts.{part.name}: controller.rate {rates[1]:g} Hz in {part.robot} is not used; write it "
                f"into this file, whose rate is {rates[0]:g} Hz by default"
            )


def digest_of(config: PartsConfig, parts: Sequence[Part], between: Between, source: str) -> str:
    """What the contact forces of a robot of parts depend on."""
    names = [part.named(name) for part in parts for name in part.robot.actuators.names]
    members = [
        [names.index(name) for name in item.members if name in names] for item in config.couplings
    ]
    touching = [*between.vertices, *(pair.triangles.ravel() for pair in between.pairs)]
    surfaces = [ids.tolist() for ids in touching]
    robots = [part.robot.digest for part in parts]
    return parts_digest(config, robots, surfaces, members, Path(source).parent)


def smallest_tolerance(contact: ContactRange, robots: Sequence[Robot]) -> float:
    """The tolerance of contact of a file, by default the smallest of the parts that have contact [m]."""
    if "tolerance" in contact.model_fields_set:
        return contact.tolerance
    return min((one.tolerance for one in robots if one.n_c > 0), default=contact.tolerance)


def check_driven(parts: Sequence[Part], source: str) -> None:
    """Raise a RobotFileError where no part has an actuator, or none an effector."""
    for what, count in (
        ("an actuator", sum(part.robot.n_a for part in parts)),
        ("an effector", sum(len(part.robot.effector_names) for part in parts)),
    ):
        if count == 0:
            raise RobotFileError(f"{source}: parts: a robot needs {what}: no part has one")


def common_alarm(sets: Sequence[ContactSet], distance: float, source: str) -> float:
    """The alarm distance of the parts that have contact [m].

    Args:
        sets: contacts of the parts.
        distance: at which surfaces are held [m].
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: parts have different ones.
    """
    alarms = sorted({one.alarm_distance for one in sets if one.n_slots > 0})
    if len(alarms) > 1:
        raise RobotFileError(
            f"{source}: contact.alarm_distance: parts have {', '.join(f'{one:g}' for one in alarms)} m; give "
            "one for all, at most the thickness of the thinnest wall"
        )
    return alarms[0] if alarms else ALARM_DISTANCE + distance


def common_distance(sets: Sequence[ContactSet], distance: float, source: str) -> float:
    """The distance at which surfaces are held, which is that of all parts [m].

    Args:
        sets: contacts of the parts.
        distance: in the file of all parts [m].
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: a part with contact has another one.
    """
    for one in sets:
        if one.n_slots > 0 and one.distance != distance:
            raise RobotFileError(
                f"{source}: contact.distance is {distance:g} m, that of a part is {one.distance:g} m: write "
                "the same into both files"
            )
    return distance


def body_surface(selector: Selector, source: str, name: str | None) -> Ints:
    """Triangles (t, 3) of a surface or region of a robot, or of its whole surface.

    Raises:
        RobotFileError: there is no such surface.
    """
    if name is None:
        return selector.boundary
    if name not in selector.named:
        raise RobotFileError(
            f"{source}: surface {name!r} is not defined, known are "
            f"{', '.join(sorted(selector.named)) or 'none'}"
        )
    return selector.boundary[selector.select_triangles(name, f"surfaces.{name}")]


def contact_between(
    config: PartsConfig,
    parts: Sequence[Part],
    loaded: Sequence[LoadedPart],
    tolerance: float,
    source: str,
) -> Between:
    """Contact between parts.

    Args:
        config: the robot file.
        parts: the parts.
        loaded: the same with their surfaces.
        tolerance: depth of obstacles in the surfaces at rest that is accepted [m].
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: a surface is unknown or has no area, an obstacle is none or in the robot.
    """
    names = [part.name for part in parts]
    surfaces: dict[tuple[int, str | None], Ints] = {}

    def triangles(side: PartSurfaceSettings, field: str) -> tuple[int, Ints]:
        key = names.index(side.part), side.surface
        if key not in surfaces:
            try:
                surfaces[key] = loaded[key[0]].surface(side.surface)
            except RobotFileError as error:
                raise RobotFileError(f"{source}: {field}.surface: {error}") from error
        return key[0], surfaces[key]

    sides = [
        (
            contact,
            triangles(contact.candidates, f"contacts.{index}.candidates"),
            None
            if isinstance(contact.against, str)
            else triangles(contact.against, f"contacts.{index}.against"),
        )
        for index, contact in enumerate(config.contacts)
    ]
    none = np.zeros(0, dtype=np.int64)
    used = [
        np.unique(
            np.concatenate(
                [none, *(ids.ravel() for (own, _), ids in surfaces.items() if own == number)]
            )
        )
        for number in range(len(parts))
    ]
    first = np.cumsum([0, *(len(ids) for ids in used)])

    def renumbered(side: tuple[int, Ints]) -> Ints:
        number, ids = side
        own: Ints = np.searchsorted(used[number], ids) + first[number]
        return own

    at_rest = np.concatenate([np.zeros((0, 3)), *map(vertices_at_rest, parts, used)])
    obstacles = {one.name: build_obstacle(one, source) for one in config.obstacles}
    touched = {side[0] for _, own, other in sides if other is not None for side in (own, other)}
    solids = {one: enclosed_by(parts[one], loaded[one].surface(None)) for one in touched}
    pairs = []
    for index, (contact, candidates, against) in enumerate(sides):
        where, own = f"{source}: contacts.{index}", renumbered(candidates)
        nodes, weights = candidates_on(at_rest, own, contact, where)
        points = np.einsum("mj,mji->mi", weights, at_rest[nodes])
        made = partial(
            ContactPair, f"{side_name(contact.candidates)} on {side_name(contact.against)}", nodes,
            weights, friction=contact.friction, bounds=force_bounds(contact),
            owner=contact.candidates.part,
        )  # fmt: skip
        if against is not None:
            other = renumbered(against)
            for there, number, side in (
                (points, against[0], contact.candidates),
                (at_rest[np.unique(other)], candidates[0], contact.against),
            ):
                overlap = f"{where}.against: {side_name(side)} is in part {names[number]!r} at rest"
                check_outside_part(there, solids[number], tolerance, overlap)
            loose = ((np.arange(len(nodes)), np.arange(len(other))),)
            pairs.append(made(other, loose=loose, other=names[against[0]]))
            continue
        assert isinstance(contact.against, str)
        obstacle = obstacles[contact.against]
        check_obstacle(obstacle, points, tolerance, where)
        pairs.append(made(NO_TRIANGLES, obstacle=obstacle))
    part_of = np.repeat(np.arange(len(parts)), np.diff(first))
    touching = [(pair, renumbered(own)) for pair, (_, own, _) in zip(pairs, sides, strict=True)]
    between = holes_between([one for one in touching if one[0].loose], at_rest, part_of)
    for note in (*between, *holes_before_obstacles(touching, at_rest)):
        log.warning("%s: %s", source, note)
    return Between(tuple(used), tuple(pairs))


def enclosed_by(part: Part, skin: Ints) -> MeshShape | None:
    """What a part encloses at rest, in the robot's frame; None where its skin is open, as tubes of beams are.

    Args:
        part: the part.
        skin: (t, 3) vertices of its whole surface.
    """
    ids, triangles = np.unique(skin, return_inverse=True)
    try:
        return MeshShape(vertices_at_rest(part, ids), triangles.reshape(skin.shape))
    except ValueError:
        return None


def check_outside_part(points: Array, solid: MeshShape | None, depth: float, message: str) -> None:
    """Raise a RobotFileError where points of another part are in a part at rest.

    Args:
        points: (m, 3) in the robot's frame [m].
        solid: what the part encloses; None: nothing is checked.
        depth: that is accepted [m].
        message: begins the error.
    """
    if solid is None:
        return
    gap, _ = solid.closest_within(points, 0.0)
    if gap.min(initial=0.0) < -depth:
        raise RobotFileError(
            f"{message}: {-1e3 * gap.min():.3g} mm deep at {np.round(points[gap.argmin()], 6).tolist()} m, "
            f"allowed is contact.tolerance, {1e3 * depth:.3g} mm; move one of the parts"
        )


def vertices_at_rest(part: Part, ids: Ints) -> Array:
    """Positions (v, 3) of vertices of a part in the robot's frame at rest [m]."""
    robot = part.robot
    placed = robot.motion(robot.rest()).placed(robot.body.surface_points(ids))
    return part.placement.points(placed.y)


def side_name(side: PartSurfaceSettings | str) -> str:
    """What one side of a contact is called."""
    return side if isinstance(side, str) else f"{side.part}.{side.surface or 'skin'}"
