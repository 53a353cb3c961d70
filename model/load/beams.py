"""From the file of a robot made of beams to a robot."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from tauten.model.actuators import (
    ActuatorSet,
    Coupling,
    ForceSet,
    TransmissionSet,
    coupling_of,
    make_chambers,
    make_forces,
    no_drives,
)
from tauten.model.beams import (
    BeamBody,
    BeamError,
    BeamLoopError,
    Beams,
    BeamSurfaces,
    BeamTree,
    Profile,
    build_beam_surfaces,
    make_beams,
    make_tree,
)
from tauten.model.body import Material
from tauten.model.contact import ContactSet
from tauten.model.load.beam_bodies import profile_of
from tauten.model.load.contacts import all_triangles, contact_set
from tauten.model.load.effectors import build_beam_effectors
from tauten.model.load.transmissions import build_beam_transmissions
from tauten.model.mesh import Selector, point_selector
from tauten.model.numerics import Array, Bools, Ints, make_factorisation
from tauten.model.points import (
    AttachedPoints,
    Paths,
    attach_to_nodes,
    join_attached_points,
    make_paths,
    no_attached_points,
)
from tauten.model.robot import Robot, names_of
from tauten.model.schema import (
    BeamConfig,
    RobotFileError,
    Structure,
    Vertebra,
    beam_robot_digest,
    check_surfaces,
    digests_of_fewer,
    read_text,
    validated,
)
from tauten.model.signals import actuators_of, limits_of
from tauten.model.system import integration_of, make_pattern


def read_structure(path: Path) -> Structure:
    """Read and validate a structure file.

    Raises:
        RobotFileError: missing, not JSON, or a field that is not allowed.
    """
    raw = read_text(path, json.loads, "JSON")
    return validated(Structure, raw, path)


def build_beam_robot(
    config: BeamConfig, structure: Structure, source: str
) -> tuple[Robot[BeamBody], dict[str, Ints]]:
    """Build a robot from validated files, and the triangles (t, 3) of each of its surfaces.

    Args:
        config: the robot file.
        structure: the structure file.
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: a beam without length, a node that no beam leads to, a cable outside of its
            vertebra, unknown names or empty regions; the text names `source`.
    """
    material = Material(**config.material.model_dump())
    profiles = build_profiles(config, structure, material, source)
    body = build_beam_body(structure, profiles, material, source)
    fixed = fixed_beam_nodes(config, body, source)
    paths, stations = build_beam_cables(config, structure, body, int(fixed.argmax()), source)
    selector = point_selector(body.nodes, config.named_regions(), source)
    forces, pushed = build_beam_forces(config, structure, body, selector)
    attach = partial(on_vertebra, structure, body)
    effectors = build_beam_effectors(config.effectors, selector, attach)
    moved = build_beam_transmissions(config.transmissions, selector, attach)
    actuators = beam_actuators(paths, stations, forces, pushed, coupling_of(config), moved)
    surfaces, named = build_beam_surfaces(structure, profiles, body)
    contacts = build_beam_contacts(config, surfaces, named, body, source)
    coupled = [] if moved is None else moved.coupled(moved.points.nodes[:, :1])
    pattern = make_pattern(
        np.repeat(fixed, 2),
        [groups(body.ends), groups(ends_of(paths, stations)), *map(groups, coupled)],
    )
    free, scheme = ~fixed, config.integration
    digest = beam_robot_digest(config, structure, Path(source).parent)
    robot = Robot(
        names=names_of(config),
        digest=digest,
        tolerance=config.contact.tolerance,
        actuators=actuators_of(config),
        limits=limits_of(config, source),
        effectors=effectors,
        contacts=contacts,
        vertices=surfaces.contact_points,
        body=BeamBody(
            gravity=np.array(config.gravity),
            integration=integration_of(config),
            actuator_set=actuators,
            pattern=pattern,
            factorisation=make_factorisation(
                pattern.indptr, pattern.indices, scheme.factorisation, scheme.threads
            ),
            floating=np.zeros(pattern.n, dtype=bool),
            beams=body,
            mass=np.repeat(np.stack([body.mass, body.inertia], axis=1)[free].ravel(), 3),
            tree=tree_of(body, fixed),
            beam_slot=pattern.blocks(groups(body.ends)),
            cable_slot=pattern.blocks(groups(ends_of(paths, stations))),
            force_slot=pattern.blocks(2 * levers_of(actuators) + 1),
            outer=effectors.pushed(np.zeros(3 * len(config.effectors))),
            surfaces=surfaces,
        ),
        digests_of_fewer=digests_of_fewer(digest, config, Path(source).parent),
    )
    return robot, named


def ends_of(paths: Paths, stations: AttachedPoints) -> Ints:
    """Nodes at both ends of every segment, cable by cable: (s, 2)."""
    node, first = stations.nodes[:, 0], paths.first
    return np.stack([node[first], node[first + 1]], axis=1)


def levers_of(actuators: ActuatorSet[AttachedPoints]) -> Ints:
    """The node of every point that a force acts on, then of those of transmissions: (p, 1)."""
    moved = actuators.transmissions
    parts = [actuators.pushed] if moved is None else [actuators.pushed, moved.points]
    return np.concatenate([part.nodes[:, :1] for part in parts])


def beam_actuators(
    paths: Paths,
    stations: AttachedPoints,
    forces: ForceSet,
    pushed: AttachedPoints,
    coupling: Coupling | None,
    transmissions: TransmissionSet[AttachedPoints] | None,
) -> ActuatorSet[AttachedPoints]:
    """Cables, forces and their couplings.

    Args:
        paths: of the cables.
        stations: points that they pass.
        forces: of fixed direction.
        pushed: the point that each of them acts on.
        coupling: of all of these.
        transmissions: functions of points; None: there are none.
    """
    return ActuatorSet(
        paths=paths,
        stations=stations,
        chambers=make_chambers([], np.zeros((0, 3))),
        walls=no_attached_points(),
        forces=forces,
        pushed=pushed,
        drives=no_drives(),
        coupling=coupling,
        transmissions=transmissions,
    )


def tree_of(body: Beams, fixed: Bools) -> BeamTree | None:
    """The tree of the beams; None: they form loops."""
    try:
        return make_tree(body, fixed)
    except BeamLoopError:
        return None


def groups(ends: Ints) -> Ints:
    """Position and rotation of groups of nodes (e, s) as groups of three unknowns: (e, 2 s)."""
    return np.stack([2 * ends, 2 * ends + 1], axis=2).reshape(len(ends), 2 * ends.shape[1])


def build_profiles(
    config: BeamConfig, structure: Structure, material: Material, source: str
) -> list[Profile]:
    """Cross-section of every beam.

    Args:
        config: the robot file.
        structure: the structure file.
        material: of the beams.
        source: the robot file's path, for errors.
    """
    known = {settings.name: profile_of(settings, material) for settings in config.profiles}
    for index, beam in enumerate(structure.beams):
        if beam.profile not in known:
            raise RobotFileError(
                f"{source}: {config.beams.file}: beams.{index}: profile {beam.profile!r} is not "
                f"defined, known are {', '.join(sorted(known))}"
            )
    return [known[beam.profile] for beam in structure.beams]


def build_beam_body(
    structure: Structure, profiles: list[Profile], material: Material, source: str
) -> Beams:
    """Beams with the masses of the vertebrae.

    Args:
        structure: the structure file.
        profiles: cross-section of each beam.
        material: of beams and vertebrae.
        source: the robot file's path, for errors.
    """
    ends = np.array([beam.ends for beam in structure.beams], dtype=np.int64)
    up = np.array([beam.up for beam in structure.beams])
    try:
        body = make_beams(np.array(structure.nodes), ends, up, profiles, material)
    except BeamError as error:
        raise RobotFileError(f"{source}: {error}") from error
    mass, inertia = body.mass.copy(), body.inertia.copy()
    for disc in structure.vertebrae:
        disc_mass = material.density * np.pi * disc.radius**2 * disc.thickness
        mass[disc.node] += disc_mass
        # mean of ½ r² about the axis and ¼ r² about the two others
        inertia[disc.node] += disc_mass * disc.radius**2 / 3.0
    return replace(body, mass=mass, inertia=inertia)


def fixed_beam_nodes(config: BeamConfig, body: Beams, source: str) -> Bools:
    """Nodes whose position and rotation are fixed, those in any of the `fixed` boxes: (n_nodes,) bool.

    Args:
        config: the robot file.
        body: the beams.
        source: the robot file's path, for errors.
    """
    fixed = np.zeros(len(body.nodes), dtype=bool)
    selector = point_selector(body.nodes, config.named_regions(), source)
    for index, region in enumerate(config.fixed):
        fixed |= selector.select_nodes(region, f"fixed.{index}")
    if fixed.all():
        raise RobotFileError(f"{source}: fixed: holds every node, no node can move")
    return fixed


def build_beam_cables(
    config: BeamConfig, structure: Structure, body: Beams, base: int, source: str
) -> tuple[Paths, AttachedPoints]:
    """Cables through holes of vertebrae, and the points that they pass.

    Args:
        config: the robot file.
        structure: the structure file.
        body: the beams.
        base: a fixed node, which pull points are attached to.
        source: the robot file's path, for errors.
    """
    cables, counts = [], []
    for index, cable in enumerate(config.cables):
        what = f"{source}: cables.{index}"
        start = [] if cable.pull_point is None else [cable.pull_point]
        route = np.array([*start, *cable.points])
        short = np.flatnonzero(np.linalg.norm(np.diff(route, axis=0), axis=1) < 1e-9)
        if len(short):
            raise RobotFileError(f"{what}.points: {short[0]} and {short[0] + 1} coincide")
        at_rest = np.full(len(start), base), np.array(start).reshape(-1, 3)
        cables += [
            attach_to_nodes(body.nodes, *at_rest),
            on_vertebra(structure, body, cable.points, what, cable.max_outside),
        ]
        counts.append(len(route))
    stations = join_attached_points(cables)
    return make_paths(counts, stations.at_rest(body.nodes)), stations


def build_beam_forces(
    config: BeamConfig, structure: Structure, body: Beams, selector: Selector
) -> tuple[ForceSet, AttachedPoints]:
    """Forces on vertebrae or spread over nodes, and the points that they act on.

    Args:
        config: the robot file.
        structure: the structure file.
        body: the beams.
        selector: of regions of the nodes.
    """
    points, shares, directions = [], [], [np.zeros((0, 3))]
    for item in config.forces:
        what = f"forces.{item.name}"
        if item.point is not None:
            where = f"{selector.source}: {what}.point"
            found = on_vertebra(structure, body, [item.point], where, item.max_outside)
            share = np.ones(1)
        else:
            assert item.region is not None
            ids = np.flatnonzero(selector.select_nodes(item.region, f"{what}.region"))
            found = attach_to_nodes(body.nodes, ids, body.nodes[ids])
            share = body.mass[ids] / body.mass[ids].sum()
        points.append(found)
        shares.append(share)
        directions.append(np.array([item.direction]) / np.linalg.norm(item.direction))
    pushed = join_attached_points(points)
    return make_forces(np.concatenate(directions), shares, pushed.at_rest(body.nodes)), pushed


def on_vertebra(
    structure: Structure,
    body: Beams,
    points: list[tuple[float, float, float]],
    what: str,
    slack: float,
) -> AttachedPoints:
    """Points attached to the vertebrae that contain them.

    Args:
        structure: the structure file.
        body: the beams.
        points: positions at rest [m].
        what: the field they come from, for errors.
        slack: largest distance of a point from its vertebra [m].

    Raises:
        RobotFileError: a point lies further away from every vertebra.
    """
    ids = []
    for number, point in enumerate(np.array(points)):
        distances = [outside(vertebra, body.nodes, point) for vertebra in structure.vertebrae]
        best = int(np.argmin(distances))
        disc = structure.vertebrae[best]
        if distances[best] > max(slack, 1e-9):
            raise RobotFileError(
                f"{what}: point {number} at {point.tolist()} m lies {distances[best]:.3g} m outside "
                f"of the nearest vertebra {disc.name!r} of radius {disc.radius} m, "
                f"allowed is {slack:g} m: move it, or set max_outside"
            )
        ids.append(disc.node)
    return attach_to_nodes(body.nodes, np.array(ids), np.array(points))


def outside(disc: Vertebra, nodes: Array, point: Array) -> float:
    """Distance of a point from a disc [m], zero inside.

    Args:
        disc: the vertebra.
        nodes: (n_nodes, 3) positions at rest [m].
        point: (3,) [m].
    """
    axis = np.array(disc.axis) / np.linalg.norm(disc.axis)
    away = point - nodes[disc.node]
    height = float(away @ axis)
    beyond = max(abs(height) - 0.5 * disc.thickness, 0.0)
    aside = max(float(np.linalg.norm(away - height * axis)) - disc.radius, 0.0)
    return float(np.hypot(beyond, aside))


def build_beam_contacts(
    config: BeamConfig, surfaces: BeamSurfaces, named: dict[str, Ints], body: Beams, source: str
) -> ContactSet:
    """Candidates and target surfaces of every contact.

    Args:
        config: the robot file.
        surfaces: of the beams.
        named: triangles of each surface of the structure file.
        body: the beams.
        source: the robot file's path, for errors.
    """
    try:
        check_surfaces(config.contacts, set(named), [one.name for one in config.obstacles])
    except ValueError as error:
        raise RobotFileError(f"{source}: {error}") from error
    triangles: dict[str | None, Ints] = {None: all_triangles(named)}
    triangles.update(named.items())
    vertices = surfaces.contact_points.at_rest(body.nodes)
    return contact_set(config, vertices, triangles, source)
