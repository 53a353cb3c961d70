"""From a robot file with parts to one robot of them."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from tauten.model.contact import ContactSet
from tauten.model.load.parts_contact import SurfaceOf, contact_between
from tauten.model.mesh import Selector
from tauten.model.numerics import Ints
from tauten.model.parts import Assembly, Between, Part, PartsBody, Placement, join_parts
from tauten.model.robot import Robot
from tauten.model.schema import (
    ALARM_DISTANCE,
    ContactRange,
    PartsConfig,
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
    surface: SurfaceOf
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
    between = contact_between(config, parts, [one.surface for one in loaded], tolerance, source)
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
