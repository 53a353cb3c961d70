"""From robot files whose bodies are all made of beams to robots: nodes that move and turn.

Where something else than the nodes of beams moves, their nodes are frames beside it
(`tauten.model.load.constraints`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tauten.model.actuators import (
    ActuatorSet,
    ForceSet,
    coupling_of,
    make_chambers,
    make_forces,
    no_drives,
)
from tauten.model.beams import (
    BeamBody,
    BeamLoopError,
    Beams,
    BeamSurfaces,
    BeamTree,
    make_tree,
    outline,
)
from tauten.model.load.actuators import build_cables
from tauten.model.load.beam_bodies import CORNERS, BeamPart
from tauten.model.load.bodies import Bodies, Shape, robot_with
from tauten.model.load.contacts import contact_set, contact_surfaces
from tauten.model.load.effectors import build_beam_effectors
from tauten.model.load.places import BeamPlaces
from tauten.model.load.transmissions import build_transmissions
from tauten.model.numerics import Bools, Ints, joined, make_factorisation
from tauten.model.points import (
    AttachedPoints,
    Paths,
    attach_to_nodes,
    join_attached_points,
    no_attached_points,
)
from tauten.model.robot import Robot
from tauten.model.schema import RobotConfig
from tauten.model.system import integration_of, make_pattern

_NO_ENDS, _NO_AXES = np.zeros((0, 2), dtype=np.int64), np.zeros((0, 4))
NO_BEAMS = Beams(np.zeros((0, 3)), _NO_ENDS, _NO_AXES, np.zeros((0, 6)), *np.zeros((3, 0)))


def of_beams_alone(config: RobotConfig) -> bool:
    """Whether the nodes of beams, of which some are fixed, are all that moves."""
    others = (config.rigid, config.attachments, config.drives, config.chambers)
    drums = any(motor.kind == "drum" for motor in config.couplings)
    bodies = all(body.beam is not None and not body.free for body in config.all_bodies)
    return bodies and not drums and not any(others)


def build_beam_robot(
    config: RobotConfig, shapes: Sequence[Shape], bodies: Bodies, joined: Ints, source: str
) -> Robot[BeamBody]:
    """Build a robot whose bodies are all made of beams.

    Args:
        config: the robot file.
        shapes: of its bodies.
        bodies: the bodies.
        joined: (n_nodes,) number of the bodies joined to each other that each node belongs to.
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: a point that lies away from the beams, unknown names or empty regions; the text names
            `source`.
    """
    beams = joined_beams(bodies.beams)
    fixed = bodies.fixed[bodies.beam_nodes]
    places = BeamPlaces(bodies, beams, fixed)
    paths, stations = build_cables(config, places)
    forces, pushed = build_beam_forces(config, places)
    effectors = build_beam_effectors(config.effectors, places)
    moved = build_transmissions(config.transmissions, places)
    actuators = ActuatorSet(
        paths=paths,
        stations=stations,
        chambers=make_chambers([], np.zeros((0, 3))),
        walls=no_attached_points(),
        forces=forces,
        pushed=pushed,
        drives=no_drives(),
        coupling=coupling_of(config),
        transmissions=moved,
    )
    surfaces = beam_surfaces(bodies, beams)
    triangles = {
        name: touched_triangles(bodies, found)
        for name, found in contact_surfaces(config, bodies.touching).items()
    }
    vertices = surfaces.contact_points.at_rest(beams.nodes)
    coupled = [] if moved is None else moved.coupled(moved.points.nodes[:, :1])
    pattern = make_pattern(
        np.repeat(fixed, 2),
        [groups(beams.ends), groups(ends_of(paths, stations)), *map(groups, coupled)],
    )
    free, scheme = ~fixed, config.integration
    body = BeamBody(
        gravity=np.array(config.gravity),
        integration=integration_of(config),
        actuator_set=actuators,
        pattern=pattern,
        factorisation=make_factorisation(
            pattern.indptr, pattern.indices, scheme.factorisation, scheme.threads
        ),
        floating=np.zeros(pattern.n, dtype=bool),
        beams=beams,
        mass=np.repeat(np.stack([beams.mass, beams.inertia], axis=1)[free].ravel(), 3),
        tree=tree_of(beams, fixed),
        beam_slot=pattern.blocks(groups(beams.ends)),
        cable_slot=pattern.blocks(groups(ends_of(paths, stations))),
        force_slot=pattern.blocks(2 * levers_of(actuators) + 1),
        outer=effectors.pushed(np.zeros(3 * len(config.effectors))),
        surfaces=surfaces,
    )
    contacts = contact_set(config, vertices, triangles, joined[touched_nodes(bodies)], source)
    return robot_with(config, shapes, source, body, effectors, contacts, surfaces.contact_points)


def ends_of(paths: Paths, stations: AttachedPoints) -> Ints:
    """Nodes at both ends of every segment, cable by cable: (s, 2)."""
    node, first = stations.nodes[:, 0], paths.first
    return np.stack([node[first], node[first + 1]], axis=1)


def levers_of(actuators: ActuatorSet[AttachedPoints]) -> Ints:
    """The node of every point that a force acts on, then of those of transmissions: (p, 1)."""
    moved = actuators.transmissions
    parts = [actuators.pushed] if moved is None else [actuators.pushed, moved.points]
    return np.concatenate([part.nodes[:, :1] for part in parts])


def tree_of(body: Beams, fixed: Bools) -> BeamTree | None:
    """The tree of the beams; None: they form loops."""
    try:
        return make_tree(body, fixed)
    except BeamLoopError:
        return None


def groups(ends: Ints) -> Ints:
    """Position and rotation of groups of nodes (e, s) as groups of three unknowns: (e, 2 s)."""
    return np.stack([2 * ends, 2 * ends + 1], axis=2).reshape(len(ends), 2 * ends.shape[1])


def build_beam_forces(config: RobotConfig, places: BeamPlaces) -> tuple[ForceSet, AttachedPoints]:
    """Forces at points or spread over nodes, and the points that they act on."""
    points, shares, directions = [], [], [np.zeros((0, 3))]
    for item in config.forces:
        what = f"forces.{item.name}"
        if item.point is not None:
            where = f"{places.source}: {what}.point"
            found, share = places.attach([item.point], where, item.max_outside), np.ones(1)
        else:
            assert item.region is not None
            ids = np.flatnonzero(places.select_nodes(item.region, f"{what}.region"))
            mass = places.beams.mass[ids]
            found, share = places.at_nodes(ids), mass / mass.sum()
        points.append(found)
        shares.append(share)
        directions.append(np.array([item.direction]) / np.linalg.norm(item.direction))
    pushed = places.join(points)
    return make_forces(np.concatenate(directions), shares, places.at_rest(pushed)), pushed


def joined_beams(parts: Sequence[BeamPart]) -> Beams:
    """All beams of a robot as one, their nodes in the order of the parts."""
    first = np.cumsum([0, *(len(part.nodes) for part in parts)])
    moved = [
        replace(part.body, ends=part.body.ends + at) for part, at in zip(parts, first, strict=False)
    ]
    return joined([NO_BEAMS, *moved])


def drawn_beams(parts: Sequence[BeamPart]) -> tuple[AttachedPoints, Ints]:
    """Surfaces of files, then outlines: points at nodes of `joined_beams`, and triangles (t, 3) of them."""
    surfaces, outlines, first = [], [], 0
    for part in parts:
        if part.shown:
            found = attach_to_nodes(part.body.nodes, part.owners, part.points)
            surfaces.append((first, found, part.triangles - part.first_follower))
        for k, profile in enumerate(part.profiles):
            outlines.append((first, *outline(part.body, k, profile)))
        first += len(part.nodes)
    points, triangles, count = [], [np.zeros((0, 3), np.int64)], 0
    for first, found, faces in [*surfaces, *outlines]:
        points.append(replace(found, nodes=found.nodes + first))
        triangles.append(faces + count)
        count += len(found)
    return join_attached_points(points), np.concatenate(triangles)


def beam_surfaces(bodies: Bodies, beams: Beams) -> BeamSurfaces:
    """The surfaces of beams, to touch and to be drawn."""
    owner = np.zeros(len(bodies.parts.mesh.nodes), dtype=np.int64)
    first = 0
    for part in bodies.beams:
        owner[part.nodes[:, None] + np.arange(CORNERS)] = (
            first + np.arange(len(part.nodes))[:, None]
        )
        owner[part.followers] = first + part.owners
        first += len(part.nodes)
    touched = touched_nodes(bodies)
    contact_points = attach_to_nodes(beams.nodes, owner[touched], bodies.parts.mesh.nodes[touched])
    drawn, triangles = drawn_beams(bodies.beams)
    every = join_attached_points([contact_points, drawn])
    lever = float(np.linalg.norm(every.offsets * every.weights[:, :, None], axis=2).max())
    return BeamSurfaces(contact_points, drawn, triangles, lever)


def touched_nodes(bodies: Bodies) -> Ints:
    """Nodes of the whole mesh in surfaces that may touch, ascending: (v,)."""
    return np.unique(bodies.touching.boundary)


def touched_triangles(bodies: Bodies, triangles: Ints) -> Ints:
    """Triangles (t, 3) of nodes of the whole mesh as triples of `touched_nodes`."""
    found: Ints = np.searchsorted(touched_nodes(bodies), triangles)
    return found
