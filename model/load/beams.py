"""From the file of a robot made of beams to a `BeamRobot`: read, check, build once."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tauten.model.beams import (
    BeamBody,
    BeamError,
    BeamRobot,
    BeamSurfaces,
    Profile,
    bar,
    build_beam_surfaces,
    make_body,
    tube,
)
from tauten.model.body import Material
from tauten.model.contact import ContactPair, ContactSet
from tauten.model.limits import limits_of
from tauten.model.mesh import in_box, spread_points
from tauten.model.numerics import Array, Bools, Ints, make_factorisation
from tauten.model.points import (
    AttachedPoints,
    BeamCables,
    carry,
    join_attached_points,
    make_beam_cables,
)
from tauten.model.schema import (
    BarSettings,
    BeamConfig,
    RobotFileError,
    Structure,
    TubeSettings,
    Vertebra,
    check_surfaces,
    validated,
)
from tauten.model.system import integration_of, make_pattern


def read_structure(path: Path) -> Structure:
    """Read and validate a structure file.

    Raises:
        RobotFileError: missing, not JSON, or a field that is not allowed.
    """
    try:
        raw = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise RobotFileError(f"{path}: cannot be read ({error})") from error
    except json.JSONDecodeError as error:
        raise RobotFileError(f"{path}: not JSON: {error}") from error
    return validated(Structure, raw, path)


def build_beam_robot(config: BeamConfig, structure: Structure, source: str) -> BeamRobot:
    """Build a robot from validated files.

    Raises:
        RobotFileError: a beam without length, a node that no beam leads to, a cable outside of its
            vertebra, names or regions that mean nothing; names `source`.
    """
    material = Material(**config.material.model_dump())
    profiles = build_profiles(config, structure, source)
    body = build_body(structure, profiles, material, source)
    fixed = fixed_nodes(config, body, source)
    cables = build_cables(config, structure, body, source)
    effectors = [
        on_vertebra(structure, body, [item.point], f"{source}: effectors.{i}", item.max_outside)
        for i, item in enumerate(config.effectors)
    ]
    hull, surfaces = build_beam_surfaces(structure, profiles, body)
    contacts = build_contacts(config, hull, surfaces, body, source)
    pattern = make_pattern(np.repeat(fixed, 2), [groups(body.ends), groups(cables.ends)])
    free = ~fixed
    scheme = config.integration
    return BeamRobot(
        config=config,
        digest=digest(body, fixed, cables, hull, contacts),
        body=body,
        integration=integration_of(config),
        pattern=pattern,
        beam_slot=pattern.blocks(groups(body.ends)),
        mass=np.repeat(np.stack([body.mass, body.inertia], axis=1)[free].ravel(), 3),
        gravity=np.array(config.gravity),
        effector_force=np.zeros(3 * len(effectors)),
        cables=cables,
        cable_slot=pattern.blocks(groups(cables.ends)),
        limits=limits_of(config.cables),
        effectors=join_attached_points(effectors),
        hull=hull,
        contacts=contacts,
        factorisation=make_factorisation(pattern.indptr, pattern.indices, scheme.factorisation),
    )


def groups(ends: Ints) -> Ints:
    """Position and rotation of both nodes as groups of three unknowns: (e, 4)."""
    first, second = 2 * ends[:, 0], 2 * ends[:, 1]
    return np.stack([first, first + 1, second, second + 1], axis=1)


def build_profiles(config: BeamConfig, structure: Structure, source: str) -> list[Profile]:
    """Cross-section of every beam."""

    def made(settings: TubeSettings | BarSettings) -> Profile:
        if isinstance(settings, TubeSettings):
            return tube(settings.outer, settings.inner)
        return bar(settings.width, settings.height)

    known = {settings.name: made(settings) for settings in config.profiles}
    for index, beam in enumerate(structure.beams):
        if beam.profile not in known:
            raise RobotFileError(
                f"{source}: {config.beams.file}: beams.{index}: profile {beam.profile!r} is not "
                f"defined, known are {', '.join(sorted(known))}"
            )
    return [known[beam.profile] for beam in structure.beams]


def build_body(
    structure: Structure, profiles: list[Profile], material: Material, source: str
) -> BeamBody:
    """Beams with the masses of the vertebrae."""
    ends = np.array([beam.ends for beam in structure.beams], dtype=np.int64)
    up = np.array([beam.up for beam in structure.beams])
    try:
        body = make_body(np.array(structure.nodes), ends, up, profiles, material)
    except BeamError as error:
        raise RobotFileError(f"{source}: {error}") from error
    for disc in structure.vertebrae:
        mass = material.density * np.pi * disc.radius**2 * disc.thickness
        body.mass[disc.node] += mass
        # mean of ½ r² about the axis and ¼ r² across
        body.inertia[disc.node] += mass * disc.radius**2 / 3.0
    return body


def fixed_nodes(config: BeamConfig, body: BeamBody, source: str) -> Bools:
    """Nodes in any of the `fixed` boxes, held in place and rotation: (n_nodes,) bool."""
    fixed = np.zeros(len(body.nodes), dtype=bool)
    for index, box in enumerate(config.fixed):
        chosen = in_box(body.nodes, box)
        if not chosen.any():
            raise RobotFileError(f"{source}: fixed.{index}: no node in {box.lower} to {box.upper}")
        fixed |= chosen
    if fixed.all():
        raise RobotFileError(f"{source}: fixed: holds every node, nothing is left to move")
    return fixed


def build_cables(
    config: BeamConfig, structure: Structure, body: BeamBody, source: str
) -> BeamCables:
    """Cables through holes of vertebrae; a pull point is held like the first fixed node."""
    cables = []
    for index, cable in enumerate(config.cables):
        what = f"{source}: cables.{index}"
        if cable.pull_point is not None:
            raise RobotFileError(
                f"{what}.pull_point: a cable of beams starts at its first hole, give that in points"
            )
        route = np.array(cable.points)
        short = np.flatnonzero(np.linalg.norm(np.diff(route, axis=0), axis=1) < 1e-9)
        if len(short):
            raise RobotFileError(f"{what}.points: {short[0]} and {short[0] + 1} coincide")
        cables.append(on_vertebra(structure, body, cable.points, what, cable.max_outside))
    return make_beam_cables(cables, body.nodes, np.tile([1.0, 0.0, 0.0, 0.0], (len(body.nodes), 1)))


def on_vertebra(
    structure: Structure,
    body: BeamBody,
    points: list[tuple[float, float, float]],
    what: str,
    slack: float,
) -> AttachedPoints:
    """MaterialPoints fixed to the vertebrae they lie in, or the nearest one within `slack` [m]."""
    ids = []
    for number, point in enumerate(np.array(points)):
        distances = [outside(vertebra, body.nodes, point) for vertebra in structure.vertebrae]
        best = int(np.argmin(distances))
        disc = structure.vertebrae[best]
        if distances[best] > max(slack, 1e-9):
            raise RobotFileError(
                f"{what}: point {number} at {point.tolist()} m lies {distances[best]:.3g} m outside "
                f"of the nearest vertebra {disc.name!r} of radius {disc.radius} m, "
                f"allowed is {slack:g} m"
            )
        ids.append(disc.node)
    return carry(body.nodes, np.array(ids), np.array(points))


def outside(disc: Vertebra, nodes: Array, point: Array) -> float:
    """How far a point lies outside of a disc [m], zero inside."""
    axis = np.array(disc.axis) / np.linalg.norm(disc.axis)
    away = point - nodes[disc.node]
    height = float(away @ axis)
    beyond = max(abs(height) - 0.5 * disc.thickness, 0.0)
    aside = max(float(np.linalg.norm(away - height * axis)) - disc.radius, 0.0)
    return float(np.hypot(beyond, aside))


def build_contacts(
    config: BeamConfig, hull: BeamSurfaces, surfaces: dict[str, Ints], body: BeamBody, source: str
) -> ContactSet:
    """Candidates and target surfaces of every contact."""
    try:
        check_surfaces(config.contacts, set(surfaces))
    except ValueError as error:
        raise RobotFileError(f"{source}: {error}") from error
    rest = np.tile([1.0, 0.0, 0.0, 0.0], (len(body.nodes), 1))
    points, _ = hull.skin.place(body.nodes, rest)
    pairs = []
    for contact in config.contacts:
        nodes, weights = spread_points(points, surfaces[contact.candidates], contact.points)
        name = f"{contact.candidates} on {contact.against}"
        pairs.append(ContactPair(name, nodes, weights, surfaces[contact.against]))
    return ContactSet(pairs, len(points), config.contact.alarm_distance)


def digest(
    body: BeamBody, fixed: Bools, cables: BeamCables, hull: BeamSurfaces, contacts: ContactSet
) -> str:
    """SHA-256 of what decides the contact forces of a robot; loads and control are left out."""
    hasher = hashlib.sha256()
    arrays: list[NDArray[Any]] = [body.nodes, body.ends, body.axes, fixed]
    arrays += [cables.starts, cables.stations.nodes, cables.stations.offsets]
    arrays += [hull.skin.nodes, hull.skin.weights, hull.skin.offsets]
    for pair in contacts.pairs:
        arrays += [pair.nodes, pair.weights, pair.triangles]
    for array in arrays:
        hasher.update(np.round(np.ascontiguousarray(array, dtype=float), 12).tobytes())
    for relative in (body.D, body.mass):  # of any size: nine digits
        hasher.update("".join(f"{value:.8e}" for value in relative.ravel()).encode())
    return hasher.hexdigest()
