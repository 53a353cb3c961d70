"""Rigid regions, drives and attachments of a robot file, on the mesh of its bodies."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from tauten.model.actuators import Coupling
from tauten.model.constraints import (
    ConstrainedRobot,
    DriveRegion,
    GluedNodes,
    RigidRegion,
    make_coordinates,
    make_frames,
    make_product_pattern,
)
from tauten.model.load.bodies import Bodies
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Bools, Ints, make_factorisation
from tauten.model.points import attach
from tauten.model.schema import AttachmentSettings, RobotConfig, RobotFileError
from tauten.model.tetra import TetRobot


@dataclass(frozen=True, slots=True)
class Constraints:
    """What nodes follow instead of moving freely.

    Attributes:
        rigid: rigid regions.
        drives: those of the drives as listed, then those of hinges on the robot's frame.
        glued: glued nodes.
    """

    rigid: list[RigidRegion]
    drives: list[DriveRegion]
    glued: GluedNodes

    def __bool__(self) -> bool:
        return bool(self.rigid or self.drives or len(self.glued.nodes))

    @property
    def regions(self) -> list[tuple[str, Ints]]:
        """Fields and nodes of all regions that move with a frame."""
        rigid = [(one.name, one.nodes) for one in self.rigid]
        return rigid + [(one.name, one.nodes) for one in self.drives]


def build_constraints(config: RobotConfig, bodies: Bodies) -> Constraints:
    """The constraints of a robot file.

    Args:
        config: the robot file.
        bodies: its bodies.

    Raises:
        RobotFileError: a region that is fixed or moves with two frames, nodes that are glued twice, or that
            lie away from what they are glued to.
    """
    selector, source = bodies.selector, bodies.selector.source
    rigid = [
        RigidRegion(f"bodies.{name}", np.flatnonzero(nodes)) for name, nodes in bodies.rigid.items()
    ]
    for item in config.rigid:
        nodes = selector.select_nodes(item.region, f"rigid.{item.name}.region")
        rigid.append(RigidRegion(f"rigid.{item.name}", np.flatnonzero(nodes)))
    drives = []
    for drive in config.drives:
        nodes = selector.select_nodes(drive.region, f"drives.{drive.name}.region")
        through = np.zeros(3) if drive.through is None else np.array(drive.through)
        region = np.flatnonzero(nodes)
        axis = np.array(drive.axis) / np.linalg.norm(drive.axis)
        drives.append(DriveRegion(f"drives.{drive.name}", region, axis, through, drive.turns))
    for index, hinge in enumerate(config.attachments):
        if hinge.to is None:
            nodes = selector.select_nodes(hinge.region, f"attachments.{index}.region")
            axis, through = axis_of(hinge)
            name = f"attachments.{index}"
            drives.append(DriveRegion(name, np.flatnonzero(nodes), axis, through, True))
    frames = Constraints(rigid, drives, GluedNodes(*no_glue()))
    require_own_nodes(frames, bodies.fixed, source)
    return Constraints(rigid, drives, build_glue(config, bodies, frames))


def require_held(config: RobotConfig, bodies: Bodies, constraints: Constraints) -> None:
    """Raise a RobotFileError where nothing holds a body, or the fixed nodes are all there are.

    Nodes that are fixed or move with a drive hold a body where three of them are not on a line. Bodies that
    are attached to each other are held together.

    Args:
        config: the robot file.
        bodies: the bodies.
        constraints: what joins them.
    """
    nodes, selector, source = bodies.parts.mesh.nodes, bodies.selector, bodies.selector.source
    supported = bodies.fixed.copy()
    for drive in constraints.drives:
        supported[drive.nodes] = True
    names = list(selector.ranges)
    of_body = np.zeros(len(nodes), dtype=np.int64)
    for number, name in enumerate(names):
        of_body[selector.nodes_of(name)] = number
    glued = constraints.glued
    pairs = np.stack([np.repeat(of_body[glued.nodes], 4), of_body[glued.masters].ravel()])
    joined = sp.coo_array((np.ones(pairs.shape[1]), pairs), shape=(len(names),) * 2)
    _, group = connected_components(joined, directed=False)
    for number, body in enumerate(config.all_bodies):
        held = nodes[supported & (group[of_body] == group[number])]
        short = 1e-6 * bodies.parts.mesh.size
        if not body.free and (
            len(held) == 0 or np.linalg.matrix_rank(held - held[0], tol=short) < 2
        ):
            whole = f"body {body.name!r}" if len(names) > 1 else "robot"
            raise RobotFileError(
                f"{source}: fixed: needs three nodes not on a line to hold the {whole}"
            )
    if bodies.fixed.all():
        raise RobotFileError(f"{source}: fixed: holds every node, no node can move")


def no_glue() -> tuple[Ints, Ints, Array]:
    """Nodes, masters and weights of no glued node."""
    none = np.zeros((0, 4), dtype=np.int64)
    return none[:, 0], none, np.zeros((0, 4))


def axis_of(item: AttachmentSettings) -> tuple[Array, Array]:
    """Unit direction (3,) of a hinge's axis and a point (3,) of it [m]."""
    assert item.axis is not None
    assert item.through is not None
    return np.array(item.axis) / np.linalg.norm(item.axis), np.array(item.through)


def require_own_nodes(constraints: Constraints, fixed: Bools, source: str) -> None:
    """Raise a RobotFileError where a region is fixed, shares nodes with another, or lies on its axis.

    Args:
        constraints: rigid regions and drives.
        fixed: (n_nodes,) bool.
        source: the robot file's path, for errors.
    """
    owner: dict[int, str] = {}
    for name, nodes in constraints.regions:
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


def build_glue(config: RobotConfig, bodies: Bodies, frames: Constraints) -> GluedNodes:
    """The nodes of all attachments to other regions.

    Args:
        config: the robot file.
        bodies: its bodies.
        frames: rigid regions and drives.

    Raises:
        RobotFileError: as `build_constraints`.
    """
    source, x0 = bodies.selector.source, bodies.parts.mesh.nodes
    moved = np.zeros(len(x0), dtype=bool)
    for _, nodes in frames.regions:
        moved[nodes] = True
    glued = np.full(len(x0), -1)
    nodes_, masters_, weights_ = ([part] for part in no_glue())
    for index, item in enumerate(config.attachments):
        if item.to is None:
            continue
        where = f"attachments.{index}"
        nodes, mesh = attached_parts(item, bodies, where)
        for found, what in (
            (bodies.fixed[nodes], "are fixed; take them out of fixed, or exchange region and to"),
            (moved[nodes], "move with a rigid region or a drive; exchange region and to"),
            (glued[nodes] >= 0, "are glued already; make the regions of the two attachments apart"),
        ):
            if found.any():
                raise RobotFileError(
                    f"{source}: {where}.region: {int(found.sum())} of its {len(nodes)} nodes {what}"
                )
        glued[nodes] = index
        try:
            found_ = attach(mesh, x0[nodes], f"{source}: {where}.region", item.max_distance)
        except ValueError as error:
            raise RobotFileError(str(error).replace("max_outside", "max_distance")) from error
        nodes_.append(nodes)
        masters_.append(found_.nodes)
        weights_.append(found_.weights)
    result = GluedNodes(np.concatenate(nodes_), np.concatenate(masters_), np.concatenate(weights_))
    both = (glued[result.masters] >= 0) & (np.abs(result.weights) > 1e-12)
    if both.any():
        first, second = glued[result.nodes[both.any(axis=1)][0]], glued[result.masters[both][0]]
        raise RobotFileError(
            f"{source}: attachments.{first}: it is glued to nodes that attachments.{second} glues; "
            "overlapping glue is not possible: move one of the regions, or give both the same `to`"
        )
    return result


def attached_parts(item: AttachmentSettings, bodies: Bodies, where: str) -> tuple[Ints, TetMesh]:
    """Nodes (g,) of an attachment, and the tetrahedra that they follow.

    Args:
        item: the attachment.
        bodies: the bodies.
        where: its field, for errors.
    """
    selector, mesh = bodies.selector, bodies.parts.mesh
    assert item.to is not None
    tets = mesh.tets[selector.select_tets(item.to, f"{where}.to")]
    chosen = selector.select_nodes(item.region, f"{where}.region")
    shared = chosen.copy()
    shared[np.setdiff1d(np.arange(len(chosen)), tets)] = False
    if shared.any():
        raise RobotFileError(
            f"{selector.source}: {where}: {int(shared.sum())} nodes of region belong to tetrahedra of to; "
            "make the two apart"
        )
    if item.kind == "hinge":
        axis, through = axis_of(item)
        assert item.radius is not None
        chosen &= np.linalg.norm(np.cross(axis, mesh.nodes - through), axis=1) <= item.radius
        if not chosen.any():
            raise RobotFileError(
                f"{selector.source}: {where}.radius: no node of region lies within {item.radius:g} m of "
                "the axis"
            )
    return np.flatnonzero(chosen), TetMesh(mesh.nodes, tets)


def constrained(
    raw: TetRobot,
    constraints: Constraints,
    config: RobotConfig,
    mass: Array,
    coupling: Coupling | None,
) -> ConstrainedRobot:
    """A robot in the coordinates that its constraints leave.

    Args:
        raw: the robot without constraints and couplings.
        constraints: the constraints.
        config: the robot file.
        mass: (n_nodes,) lumped mass [kg].
        coupling: of all actuators.
    """
    x0, dof = raw.mesh.nodes, raw.pattern.dof
    number = np.where(dof >= 0, dof // 3, -1)
    frames = make_frames(constraints.rigid, constraints.drives, number, x0, mass)
    coordinates = make_coordinates(frames, constraints.glued, number, x0)
    product = make_product_pattern(coordinates, raw.pattern, frames)
    names = [item.name for item in config.single_actuators]
    pattern = product.pattern
    rest = coordinates.values(frames.place(frames.rest())[1])
    inertia = product.inertia.apply(raw.mass, rest, len(pattern.indices))
    return ConstrainedRobot(
        names=raw.names,
        digest=constrained_digest(raw, constraints),
        gravity=raw.gravity,
        tolerance=raw.tolerance,
        integration=raw.integration,
        pattern=pattern,
        mass=inertia[pattern.diagonal],
        actuators=raw.actuators,
        actuator_set=raw.actuator_set,
        limits=raw.limits,
        effectors=raw.effectors,
        contacts=raw.contacts,
        factorisation=make_factorisation(
            pattern.indptr, pattern.indices, config.integration.factorisation
        ),
        raw=raw,
        frames=frames,
        coordinates=coordinates,
        product=product,
        coupling=coupling,
        drive_places=np.array([names.index(item.name) for item in config.drives], dtype=np.int64),
        driven=np.arange(len(config.drives)),
    )


def constrained_digest(raw: TetRobot, constraints: Constraints) -> str:
    """SHA-256 of the robot and of what its nodes follow."""
    hasher = hashlib.sha256(raw.digest.encode())
    for name, nodes in constraints.regions:
        hasher.update(name.encode() + nodes.tobytes())
    for drive in constraints.drives:
        for part in (drive.axis, drive.through):
            hasher.update(np.round(part, 12).tobytes())
        hasher.update(bytes([drive.turns]))
    glued = constraints.glued
    hasher.update(glued.nodes.tobytes() + glued.masters.tobytes())
    hasher.update(np.round(glued.weights, 9).tobytes())
    return hasher.hexdigest()
