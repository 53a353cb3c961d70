"""Contact between the parts of a robot, and between parts and obstacles."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from tauten.model.contact import (
    ContactPair,
    MeshShape,
    enclosed,
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
from tauten.model.numerics import Array, Ints
from tauten.model.parts import Between, Part
from tauten.model.schema import (
    PartContactSettings,
    PartsConfig,
    PartSurfaceSettings,
    RobotFileError,
)

log = logging.getLogger(__name__)

SurfaceOf = Callable[
    [str | None], Ints
]  # triangles (t, 3) of a part by the name of a surface; None: all


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """One side of a contact.

    Attributes:
        part: its number.
        triangles: (t, 3) vertices of the part.
        name: as in the names of contacts.
    """

    part: int
    triangles: Ints
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class _Touching:
    """A contact of the file.

    Attributes:
        settings: as in the file.
        where: file and field.
        candidates: the side that candidates are spread over.
        against: a surface of another part; None: the settings name an obstacle.
    """

    settings: PartContactSettings
    where: str
    candidates: _Side
    against: _Side | None


@dataclass(frozen=True, slots=True, eq=False)
class _Vertices:
    """The vertices of all parts that contacts use, numbered one part after another.

    Attributes:
        used: of each part, those of its vertices that are used, in order.
        first: (p + 1,) where those of each part start.
        at_rest: (v, 3) positions in the robot's frame [m].
    """

    used: tuple[Ints, ...]
    first: Ints
    at_rest: Array

    @classmethod
    def of(cls, parts: Sequence[Part], contacts: Sequence[_Touching]) -> _Vertices:
        """Those of some contacts."""
        found: list[list[Ints]] = [[np.zeros(0, dtype=np.int64)] for _ in parts]
        for contact in contacts:
            for side in (contact.candidates, contact.against):
                if side is not None:
                    found[side.part].append(side.triangles.ravel())
        used = tuple(np.unique(np.concatenate(own)) for own in found)
        at_rest = [np.zeros((0, 3)), *map(vertices_at_rest, parts, used)]
        return cls(used, np.cumsum([0, *map(len, used)]), np.concatenate(at_rest))

    def of_side(self, side: _Side) -> Ints:
        """The triangles (t, 3) of a side in these numbers."""
        own: Ints = np.searchsorted(self.used[side.part], side.triangles) + self.first[side.part]
        return own

    @property
    def part(self) -> Ints:
        """The number of the part of each vertex (v,)."""
        return np.repeat(np.arange(len(self.used)), np.diff(self.first))


def contact_between(
    config: PartsConfig,
    parts: Sequence[Part],
    surfaces: Sequence[SurfaceOf],
    tolerance: float,
    source: str,
) -> Between:
    """Contact between parts.

    Args:
        config: the robot file.
        parts: the parts.
        surfaces: of each, its surfaces by name; they raise a RobotFileError where there is no such one.
        tolerance: depth of obstacles in the surfaces at rest that is accepted [m].
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: a surface is unknown or has no area, an obstacle is none or in the robot.
    """
    contacts = _contacts(config, parts, surfaces, source)
    vertices = _Vertices.of(parts, contacts)
    obstacles = {one.name: build_obstacle(one, source) for one in config.obstacles}
    touched = {
        side.part
        for contact in contacts
        if contact.against is not None
        for side in (contact.candidates, contact.against)
    }
    solids = {number: enclosed_by(parts[number], surfaces[number](None)) for number in touched}
    pairs = []
    for contact in contacts:
        made = _pair_against_nothing(contact, vertices)
        points = made.candidates(vertices.at_rest)
        name = contact.settings.against
        if isinstance(name, str):
            check_obstacle(obstacles[name], points, tolerance, contact.where)
            pairs.append(replace(made, obstacle=obstacles[name]))
        if contact.against is not None:
            other = vertices.of_side(contact.against)
            corners = vertices.at_rest[np.unique(other)]
            for there, side, within in (
                (points, contact.candidates, contact.against),
                (corners, contact.against, contact.candidates),
            ):
                is_in = f"{side.name} is in part {parts[within.part].name!r} at rest"
                message = f"{contact.where}.against: {is_in}"
                check_outside_part(there, solids[within.part], tolerance, message)
            loose = ((np.arange(len(made.nodes)), np.arange(len(other))),)
            owner = parts[contact.against.part].name
            pairs.append(replace(made, triangles=other, loose=loose, other=owner))
    touching = [
        (pair, vertices.of_side(contact.candidates))
        for pair, contact in zip(pairs, contacts, strict=True)
    ]
    between = holes_between(touching, vertices.at_rest, vertices.part)
    for note in (*between, *holes_before_obstacles(touching, vertices.at_rest)):
        log.warning("%s: %s", source, note)
    return Between(vertices.used, tuple(pairs))


def _contacts(
    config: PartsConfig, parts: Sequence[Part], surfaces: Sequence[SurfaceOf], source: str
) -> list[_Touching]:
    """The contacts of a file with their surfaces.

    Raises:
        RobotFileError: a surface is unknown.
    """
    names = [part.name for part in parts]

    @cache
    def surface(number: int, name: str | None) -> Ints:
        return surfaces[number](name)

    def side(settings: PartSurfaceSettings, field: str) -> _Side:
        number = names.index(settings.part)
        try:
            triangles = surface(number, settings.surface)
        except RobotFileError as error:
            raise RobotFileError(f"{source}: {field}.surface: {error}") from error
        return _Side(number, triangles, settings.name)

    found = []
    for index, contact in enumerate(config.contacts):
        field, against = f"contacts.{index}", contact.against
        candidates = side(contact.candidates, f"{field}.candidates")
        other = None if isinstance(against, str) else side(against, f"{field}.against")
        found.append(_Touching(contact, f"{source}: {field}", candidates, other))
    return found


def _pair_against_nothing(contact: _Touching, vertices: _Vertices) -> ContactPair:
    """The candidates of a contact, which touch nothing yet.

    Raises:
        RobotFileError: their surface has no area.
    """
    settings, own = contact.settings, vertices.of_side(contact.candidates)
    nodes, weights = candidates_on(vertices.at_rest, own, settings, contact.where)
    return ContactPair(
        name=settings.name,
        nodes=nodes,
        weights=weights,
        triangles=NO_TRIANGLES,
        friction=settings.friction,
        bounds=force_bounds(settings),
        owner=settings.candidates.part,
    )


def enclosed_by(part: Part, skin: Ints) -> MeshShape | None:
    """What a part encloses at rest with its skin (t, 3), in the robot's frame; None: it is open, as tubes."""
    ids, triangles = np.unique(skin, return_inverse=True)
    return enclosed(vertices_at_rest(part, ids), triangles.reshape(skin.shape))


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
