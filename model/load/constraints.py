"""Rigid regions, drives and attachments of a robot file, on the mesh of its bodies."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from tauten.model.actuators import ActuatorSet, DriveSet
from tauten.model.constraints import (
    ConstrainedBody,
    DriveRegion,
    Drums,
    FrameJoints,
    Frames,
    GluedNodes,
    PinnedRegion,
    RigidRegion,
    make_coordinates,
    make_frames,
    make_product_pattern,
    supports_of,
)
from tauten.model.load.beam_bodies import BeamPart
from tauten.model.load.beams import drawn_beams, joined_beams
from tauten.model.load.bodies import Bodies
from tauten.model.load.joins import (
    AnyFrame,
    attached_parts,
    axis_of,
    build_glue,
    join_frames,
    require_no_circle,
)
from tauten.model.numerics import Bools, Ints, make_factorisation
from tauten.model.points import MeanPoints, NodePoints, Paths
from tauten.model.schema import RobotConfig, RobotFileError
from tauten.model.system import Integration
from tauten.model.tetra import Tetrahedra


@dataclass(frozen=True, slots=True)
class Constraints:
    """What nodes follow instead of moving freely.

    Attributes:
        frames: rigid regions, among them the free nodes of beams; pinned regions; drives as listed, then
            hinges on the robot's frame, then drums, which have no nodes.
        glued: glued nodes.
        springs: see `FrameJoints`.
    """

    frames: list[AnyFrame]
    glued: GluedNodes
    springs: sp.csr_array

    def __bool__(self) -> bool:
        return bool(self.frames or len(self.glued.nodes))

    @property
    def rigid(self) -> list[RigidRegion]:
        """Rigid regions."""
        return [one for one in self.frames if isinstance(one, RigidRegion)]

    @property
    def pinned(self) -> list[PinnedRegion]:
        """Pinned regions."""
        return [one for one in self.frames if isinstance(one, PinnedRegion)]

    @property
    def drives(self) -> list[DriveRegion]:
        """Regions of drives."""
        return [one for one in self.frames if isinstance(one, DriveRegion)]

    def carriers(self, fixed: Bools) -> Ints:
        """What carries each node rigidly: zero what is fixed (n_nodes,), then the regions, −1 nothing."""
        frame = self.frame_of(len(fixed))
        return np.where(frame < 0, np.where(fixed, 0, -1), 1 + frame)

    def frame_of(self, n_nodes: int) -> Ints:
        """Which of the frames carries each node, −1 none: (n_nodes,)."""
        found = np.full(n_nodes, -1)
        for number, frame in enumerate(self.frames):
            found[frame.nodes] = number
        return found


def build_constraints(config: RobotConfig, bodies: Bodies) -> Constraints:
    """The constraints of a robot file.

    Raises:
        RobotFileError: a region that is fixed or moves with two frames, nodes that are glued twice, or that
            lie away from what they are glued to.
    """
    source = bodies.selector.source
    rigid = [
        RigidRegion(f"bodies.{name}", np.flatnonzero(nodes)) for name, nodes in bodies.rigid.items()
    ]
    for item in config.rigid:
        nodes = bodies.select_nodes(item.region, f"rigid.{item.name}.region")
        rigid.append(RigidRegion(f"rigid.{item.name}", np.flatnonzero(nodes)))
    drives = []
    for drive in config.drives:
        nodes = bodies.select_nodes(drive.region, f"drives.{drive.name}.region")
        through = np.zeros(3) if drive.through is None else np.array(drive.through)
        region = np.flatnonzero(nodes)
        axis = np.array(drive.axis) / np.linalg.norm(drive.axis)
        drives.append(DriveRegion(f"drives.{drive.name}", region, axis, through, drive.turns))
    for index, hinge in enumerate(config.attachments):
        if hinge.to is None:
            nodes = bodies.select_nodes(hinge.region, f"attachments.{index}.region")
            axis, through = axis_of(hinge)
            name = f"attachments.{index}"
            drives.append(DriveRegion(name, np.flatnonzero(nodes), axis, through, True))
    for motor in config.couplings:
        if motor.kind == "drum":
            none, along = np.zeros(0, np.int64), np.array([1.0, 0.0, 0.0])
            name = f"couplings.{motor.name}"
            drives.append(DriveRegion(name, none, along, np.zeros(3), False))
    require_own_nodes([*rigid, *drives], bodies.fixed, source)
    attachments = [
        attached_parts(item, bodies, f"attachments.{index}")
        for index, item in enumerate(config.attachments)
        if item.to is not None
    ]
    frames, springs = join_frames(bodies, rigid, drives, attachments)
    found = Constraints(frames, build_glue(attachments, bodies, frames), springs)
    require_no_circle(found.pinned, found.glued, len(bodies.fixed), source)
    return found


def require_own_nodes(regions: list[RigidRegion | DriveRegion], fixed: Bools, source: str) -> None:
    """Raise a RobotFileError where a region is fixed, shares nodes with another, or lies on its axis.

    Args:
        regions: rigid regions and drives.
        fixed: (n_nodes,) bool.
        source: the robot file's path, for errors.
    """
    owner: dict[int, str] = {}
    for region in regions:
        name, nodes = region.name, region.nodes
        held = int(fixed[nodes].sum())
        if held:
            raise RobotFileError(
                f"{source}: {name}: {held} of its {len(nodes)} nodes are fixed; take them out of fixed or "
                "out of the region"
            )
        twice = [owner[node] for node in nodes.tolist() if node in owner]
        if twice:
            raise RobotFileError(
                f"{source}: {name}: {len(twice)} of its {len(nodes)} nodes move with {twice[0]} too, a node "
                "moves with one of them"
            )
        owner.update(dict.fromkeys(nodes.tolist(), name))


def constrained(
    tetrahedra: Tetrahedra,
    constraints: Constraints,
    config: RobotConfig,
    bodies: Bodies,
    scheme: Integration,
    actuators: ActuatorSet[NodePoints | MeanPoints],
    loose: Bools,
) -> ConstrainedBody:
    """A body in the coordinates that its constraints leave.

    Args:
        tetrahedra: of all bodies.
        constraints: the constraints.
        config: the robot file.
        bodies: the bodies, with masses and beams.
        scheme: of its steps.
        actuators: cables, chambers, forces and couplings.
        loose: (n_nodes,) which nodes belong to bodies that nothing holds.
    """
    x0, dof = tetrahedra.mesh.nodes, tetrahedra.dof
    number = np.where(dof >= 0, dof // 3, -1)
    rigid, pinned, drives = constraints.rigid, constraints.pinned, constraints.drives
    frames = make_frames(
        rigid, pinned, drives, number, x0, bodies.parts.mass, bodies.parts.lumpings
    )
    joints = beam_joints(bodies.beams, constraints.frame_of(len(x0)), constraints.springs)
    paths, stations = actuators.paths, actuators.stations
    assert isinstance(stations, NodePoints)  # cables pass combinations of a few nodes each
    drums = build_drums(config, paths, stations, len(drives), number)
    none = np.zeros(0, dtype=np.int64)
    turning = none if joints is None else joints.turning
    wound = none if drums is None else drums.regions
    coordinates = make_coordinates(frames, pinned, constraints.glued, turning, wound, number, x0)
    entries = (none, none) if joints is None else joints.entries(number)
    if drums is not None:
        more = drums.entries(len(coordinates.indptr) - 1 - len(wound))
        i, j = (np.concatenate(pair) for pair in zip(entries, more, strict=True))
        entries = i, j
    product = make_product_pattern(coordinates, tetrahedra.pattern, frames, entries)
    pattern, driven = product.pattern, np.arange(len(config.drives))
    solver = config.integration
    body = ConstrainedBody(
        gravity=np.array(config.gravity),
        integration=scheme,
        actuator_set=replace(
            actuators, drives=build_drives(config, frames, driven, wound, coordinates.n)
        ),
        pattern=pattern,
        factorisation=make_factorisation(
            pattern.indptr, pattern.indices, solver.factorisation, solver.threads
        ),
        floating=np.zeros(pattern.n, dtype=bool),
        tetrahedra=tetrahedra,
        frames=frames,
        coordinates=coordinates,
        product=product,
        driven=driven,
        joints=joints,
        spring_values=np.zeros(0) if joints is None else joints.spring_tangent(number).data,
        drums=drums,
    )
    if not loose.any():
        return body
    # SciPy sorts the entries of a matrix in place, and those of the map have an order of their own
    T = coordinates.matrix(body.placed(body.rest())[1].T).copy()
    T.data = np.abs(T.data)
    moved = T.T @ np.concatenate(
        [np.repeat(loose[dof >= 0], 3), np.zeros(T.shape[0] - tetrahedra.m)]
    )
    return replace(body, floating=moved > 0.0)


def beam_joints(parts: list[BeamPart], turning: Ints, springs: sp.csr_array) -> FrameJoints | None:
    """All beams of a robot, and its springs; None: it has neither.

    Args:
        parts: the bodies made of beams.
        turning: (n_nodes,) region that each node of the robot moves with, −1: none.
        springs: see `FrameJoints`.
    """
    if not parts and springs.shape[0] == 0:
        return None
    beams, (points, triangles) = joined_beams(parts), drawn_beams(parts)
    nodes = np.concatenate([np.zeros(0, np.int64), *(part.nodes for part in parts)])
    return FrameJoints(
        nodes=nodes,
        turning=turning[nodes],
        beams=beams.arrays,
        inertia=beams.inertia,
        outline=points,
        triangles=triangles,
        springs=springs,
    )


def build_drives(
    config: RobotConfig, frames: Frames, driven: Ints, wound: Ints, n: int
) -> DriveSet:
    """The drives of a robot file, then its drums, whose places are after all single actuators.

    Args:
        config: the robot file.
        frames: regions that move with a frame.
        driven: (m,) numbers of the drives among the drive regions.
        wound: (d,) numbers of the drums among them.
        n: unknowns of the robot, the last of which are those of drive regions.
    """
    names = [item.name for item in config.single_actuators]
    places = np.array([names.index(item.name) for item in config.drives], dtype=np.int64)
    travels = np.concatenate([driven, wound])
    return DriveSet(
        places=np.concatenate([places, len(names) + np.arange(len(wound))]),
        columns=n - frames.n_drives + travels,
        travels=travels,
        axes=frames.axes[driven],
        beside=np.array([frames.beside(drive) for drive in driven]).reshape(-1, 3),
        slides=~frames.turns[driven],
    )


def build_drums(
    config: RobotConfig, paths: Paths, stations: NodePoints, n_drives: int, number: Ints
) -> Drums | None:
    """The drums of a robot file; None: it has none.

    Args:
        config: the robot file.
        paths: of all cables.
        stations: points that they pass.
        n_drives: drive regions, the last of which are drums.
        number: (n_nodes,) number of each node among those that are not fixed.
    """
    names = [cable.name for cable in config.cables]
    items = [item for item in config.couplings if item.kind == "drum"]
    if not items:
        return None
    chosen = [names.index(name) for item in items for name in item.members]
    springs = [config.cables[cable].spring for cable in chosen]
    order = [item.name for item in config.actuators]
    return Drums(
        cables=np.array(chosen),
        owner=np.repeat(np.arange(len(items)), [len(item.members) for item in items]),
        gains=np.array([gain for item in items for gain in item.gains]),
        stiffness=np.array([spring.stiffness for spring in springs if spring]),
        pretension=np.array([spring.pretension for spring in springs if spring]),
        motors=np.array([order.index(item.name) for item in items]),
        regions=n_drives - len(items) + np.arange(len(items)),
        supports=supports_of(paths, stations, chosen, number),
    )
