"""What joins bodies: pins and hinges between rigid ones, beams and nodes glued to others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from tauten.model.constraints import DriveRegion, GluedNodes, PinnedRegion, RigidRegion
from tauten.model.load.bodies import Bodies
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.points import NodePoints, attach, combinations
from tauten.model.schema import AttachmentSettings, RobotFileError

ROUNDING = 1e-12  # of weights, which are of the order of one
AnyFrame = RigidRegion | PinnedRegion | DriveRegion


@dataclass(frozen=True, slots=True)
class Attachment:
    """An attachment of a robot file with what it selects.

    Attributes:
        item: its table.
        where: its field, for errors.
        chosen: (n_nodes,) which nodes its `region` selects, of beams with their corners.
        to: the tetrahedra that they follow.
        of_beams: (e,) which of these stand for nodes of beams.
    """

    item: AttachmentSettings
    where: str
    chosen: Bools
    to: TetMesh
    of_beams: Bools

    def follow(self, points: Array, source: str) -> NodePoints:
        """Points (p, 3) [m] attached to what they follow.

        Raises:
            RobotFileError: one lies further away than `max_distance`.
        """
        try:
            where = f"{source}: {self.where}.region"
            found = attach(self.to, points, where, self.item.max_distance, of_beams=self.of_beams)
        except ValueError as error:
            raise RobotFileError(str(error).replace("max_outside", "max_distance")) from error
        used = np.abs(found.weights) > ROUNDING  # the others are no masters
        return combinations(found.nodes, np.where(used, found.weights, 0.0))


def join_frames(
    bodies: Bodies,
    rigid: list[RigidRegion],
    drives: list[DriveRegion],
    attachments: list[Attachment],
) -> tuple[list[AnyFrame], sp.csr_array]:
    """All frames, with those of beams' nodes, pins and hinges, and springs, see `FrameJoints`.

    Raises:
        RobotFileError: what cannot be joined in this way.
    """
    source, x0 = bodies.selector.source, bodies.parts.mesh.nodes
    taken = bodies.fixed.copy()
    listed: list[AnyFrame] = [*rigid, *drives]
    for frame in listed:
        taken[frame.nodes] = True
    pinned: list[PinnedRegion] = []
    glued: list[tuple[int, Attachment]] = []
    rows: list[sp.csr_array] = []
    for one in attachments:
        whole = [region for region in rigid if one.chosen[region.nodes].all()]
        if one.item.kind == "pin" or (one.item.kind == "hinge" and whole):
            if whole:
                pinned.append(pinned_body(bodies, one, whole[0]))
                rigid = [region for region in rigid if region is not whole[0]]
                if one.item.kind == "hinge":
                    rows += alignment(bodies, one, pinned[-1])
            else:
                pinned += pinned_nodes(bodies, one, taken)
        elif one.item.kind == "glue":
            own = beam_nodes(bodies, one.chosen)
            require_free(own, taken, one, source)
            glued += [(node, one) for node in own.tolist()]
        for node in beam_nodes(bodies, one.chosen):
            taken[bodies.corners_of(node)] = True
    rigid = list(rigid)
    for part in bodies.beams:
        free = part.nodes[~taken[part.nodes]]
        rigid += [RigidRegion(f"bodies.{part.name}", bodies.corners_of(node)) for node in free]
    frames: list[AnyFrame] = [*rigid, *pinned, *drives]
    glue_beams(bodies, frames, glued)
    return frames, sp.csr_array(sp.vstack([sp.csr_array((0, x0.size)), *rows]))


def glue_beams(bodies: Bodies, frames: list[AnyFrame], glued: list[tuple[int, Attachment]]) -> None:
    """Add nodes of beams to the frames that they are glued to."""
    source, x0 = bodies.selector.source, bodies.parts.mesh.nodes
    for node, one in glued:
        masters = one.follow(x0[[node]], source).nodes[0]
        place = next((i for i, f in enumerate(frames) if np.isin(masters, f.nodes).all()), None)
        if place is None:
            raise RobotFileError(
                f"{source}: {one.where}: a node of a beam is glued to what is rigid; at a soft body exchange "
                'region and to, or let kind = "pin" hold its position'
            )
        nodes = np.concatenate([frames[place].nodes, bodies.corners_of(node)])
        frames[place] = replace(frames[place], nodes=nodes)


def beam_nodes(bodies: Bodies, chosen: Bools) -> Ints:
    """Those of some nodes (n_nodes,) that are nodes of beams, without their corners."""
    nodes = bodies.beam_nodes
    return nodes[chosen[nodes]]


def require_free(nodes: Ints, taken: Bools, one: Attachment, source: str) -> None:
    """Raise a RobotFileError where nodes of beams are held by something else already.

    Args:
        nodes: the nodes.
        taken: (n_nodes,) which nodes are.
        one: the attachment that needs them.
        source: the robot file's path.
    """
    count = int(taken[nodes].sum())
    if count:
        raise RobotFileError(
            f"{source}: {one.where}.region: {count} of its {len(nodes)} nodes of beams are fixed, move with "
            "a frame or are attached already; take them out of one of the two"
        )


def pinned_nodes(bodies: Bodies, one: Attachment, taken: Bools) -> list[PinnedRegion]:
    """The nodes of beams that a pin holds by their positions.

    Args:
        bodies: the bodies.
        one: the pin.
        taken: (n_nodes,) which nodes are held already.
    """
    source, x0 = bodies.selector.source, bodies.parts.mesh.nodes
    nodes = beam_nodes(bodies, one.chosen)
    if len(nodes) == 0:
        raise RobotFileError(
            f"{source}: {one.where}.region: a pin holds nodes of a beam or a rigid body, found neither"
        )
    if one.item.through is not None:
        raise RobotFileError(
            f"{source}: {one.where}.through: the nodes of a beam are pinned where they are, leave it out"
        )
    require_free(nodes, taken, one, source)
    found = one.follow(x0[nodes], source)
    return [
        PinnedRegion(one.where, bodies.corners_of(node), x0[node], masters, weights)
        for node, masters, weights in zip(nodes, found.nodes, found.weights, strict=True)
    ]


def pinned_body(bodies: Bodies, one: Attachment, region: RigidRegion) -> PinnedRegion:
    """A rigid body that turns about a point."""
    source = bodies.selector.source
    if one.item.through is None:
        raise RobotFileError(
            f"{source}: {one.where}.through: needed by the pin of a rigid body: the point that it turns about"
        )
    pin = np.array(one.item.through)
    found = one.follow(pin[None], source)
    masters, weights = found.nodes[0], found.weights[0]
    return PinnedRegion(region.name, region.nodes, pin, masters, weights)


def alignment(bodies: Bodies, one: Attachment, body: PinnedRegion) -> list[sp.csr_array]:
    """Springs (3, 3 n_nodes) that keep the axis of a hinge common to two rigid bodies, see `FrameJoints`.

    Two springs, at the same distance on both sides of the pin, press a couple only.
    """
    source, mesh = bodies.selector.source, bodies.parts.mesh
    if one.item.radius is not None:
        raise RobotFileError(
            f"{source}: {one.where}.radius: a rigid body turns about its axis, leave it out"
        )
    axis, _ = axis_of(one.item)
    arm = float(np.linalg.norm(mesh.nodes[body.nodes] - body.pin, axis=1).max())
    root = np.sqrt(0.5 * one.item.tilt_stiffness) / arm
    own = mesh.tets[np.isin(mesh.tets, body.nodes).all(axis=1)][0]
    rows = []
    for sign in (1.0, -1.0):
        point = body.pin + sign * arm * axis
        weights = np.concatenate(
            [combination(mesh.nodes[own], point), -combination(mesh.nodes[body.masters], point)]
        )
        columns = np.concatenate([own, body.masters])
        shape = (1, len(mesh.nodes))
        row = sp.csr_array((root * weights, (np.zeros(len(columns), int), columns)), shape=shape)
        rows.append(sp.csr_array(sp.kron(row, np.eye(3), format="csr")))
    return rows


def axis_of(item: AttachmentSettings) -> tuple[Array, Array]:
    """Unit direction (3,) of a hinge's axis and a point (3,) of it [m]."""
    assert item.axis is not None
    assert item.through is not None
    return np.array(item.axis) / np.linalg.norm(item.axis), np.array(item.through)


def combination(corners: Array, point: Array) -> Array:
    """Weights (4,) of the corners (4, 3) of a tetrahedron that make up a point (3,)."""
    edges = (corners[1:] - corners[0]).T
    w = np.linalg.solve(edges, point - corners[0])
    return np.concatenate([[1.0 - w.sum()], w])


def require_no_circle(pinned: list[PinnedRegion], glued: GluedNodes, n: int, source: str) -> None:
    """Raise a RobotFileError where parts follow each other in a circle."""
    used = glued.weights != 0.0
    rows = [np.repeat(glued.nodes, used.sum(axis=1))]
    columns = [glued.masters[used]]
    for one in pinned:  # all its nodes follow its masters
        masters = one.masters[one.weights != 0.0]
        rows += [np.repeat(one.nodes, len(masters))]
        columns += [np.tile(masters, len(one.nodes))]
    i, j = np.concatenate(rows), np.concatenate(columns)
    graph = sp.coo_array((np.ones(len(i)), (i, j)), shape=(n, n))
    _, group = connected_components(graph, directed=True, connection="strong")
    inside = group[i] == group[j]
    if inside.any():
        node = i[inside][0]
        names = [one.name for one in pinned if node in one.nodes] or ["glue"]
        raise RobotFileError(
            f"{source}: {names[0]}: it follows parts that follow it; join them in one direction only"
        )


def build_glue(
    attachments: list[Attachment], bodies: Bodies, frames: Sequence[AnyFrame]
) -> GluedNodes:
    """The nodes of all attachments to other regions that move with no frame.

    Raises:
        RobotFileError: as `build_constraints`.
    """
    source, x0 = bodies.selector.source, bodies.parts.mesh.nodes
    moved = np.zeros(len(x0), dtype=bool)
    for frame in frames:
        moved[frame.nodes] = True
    of_beams = np.zeros(len(x0), dtype=bool)
    of_beams[bodies.beam_nodes] = True
    of_beams = bodies.with_corners(of_beams)
    glued = np.full(len(x0), -1)
    none = np.zeros((0, 4), dtype=np.int64)
    nodes_, masters_, weights_ = [none[:, 0]], [none], [np.zeros((0, 4))]
    for index, one in enumerate(attachments):
        nodes = np.flatnonzero(one.chosen & ~of_beams)
        of_bodies = [f.nodes[~of_beams[f.nodes]] for f in frames if isinstance(f, PinnedRegion)]
        whole = any(len(own) > 0 and bool(one.chosen[own].all()) for own in of_bodies)
        if one.item.kind == "pin" or (one.item.kind == "hinge" and whole) or len(nodes) == 0:
            continue
        if one.item.kind == "hinge":
            nodes = near_axis(one, nodes, bodies)
        for found, what in (
            (bodies.fixed[nodes], "are fixed; take them out of fixed, or exchange region and to"),
            (moved[nodes], "move with a rigid region or a drive; exchange region and to"),
            (glued[nodes] >= 0, "are glued already; make the regions of the two attachments apart"),
        ):
            if found.any():
                raise RobotFileError(
                    f"{source}: {one.where}.region: {int(found.sum())} of its {len(nodes)} nodes {what}"
                )
        glued[nodes] = index
        found_ = one.follow(x0[nodes], source)
        nodes_.append(nodes)
        masters_.append(found_.nodes)
        weights_.append(found_.weights)
    result = GluedNodes(np.concatenate(nodes_), np.concatenate(masters_), np.concatenate(weights_))
    both = (glued[result.masters] >= 0) & (np.abs(result.weights) > 1e-12)
    if both.any():
        first, second = glued[result.nodes[both.any(axis=1)][0]], glued[result.masters[both][0]]
        raise RobotFileError(
            f"{source}: {attachments[first].where}: it is glued to nodes that {attachments[second].where} "
            "glues; overlapping glue is not possible: move one of the regions, or give both the same `to`"
        )
    return result


def attached_parts(item: AttachmentSettings, bodies: Bodies, where: str) -> Attachment:
    """An attachment to another region with what it selects."""
    selector, mesh = bodies.selector, bodies.parts.mesh
    assert item.to is not None
    tets = mesh.tets[selector.select_tets(item.to, f"{where}.to")]
    chosen = bodies.select_nodes(item.region, f"{where}.region")
    shared = chosen.copy()
    shared[np.setdiff1d(np.arange(len(chosen)), tets)] = False
    if shared.any():
        raise RobotFileError(
            f"{selector.source}: {where}: {int(shared.sum())} nodes of region belong to tetrahedra of to; "
            "make the two apart"
        )
    if not chosen.any():
        raise RobotFileError(
            f"{selector.source}: {where}.region: it has no node of a beam, only corners beside one; make it "
            "larger"
        )
    to = TetMesh(mesh.nodes, tets)
    return Attachment(item, where, chosen, to, bodies.of_beams(to))


def near_axis(one: Attachment, nodes: Ints, bodies: Bodies) -> Ints:
    """Those of some nodes that the hinge of a soft body ties.

    Args:
        one: the hinge.
        nodes: of its region.
        bodies: the bodies.
    """
    source, x0 = bodies.selector.source, bodies.parts.mesh.nodes
    axis, through = axis_of(one.item)
    if one.item.radius is None:
        raise RobotFileError(
            f"{source}: {one.where}.radius: needed by the hinge of a body that is not rigid as a whole"
        )
    near = np.linalg.norm(np.cross(axis, x0[nodes] - through), axis=1) <= one.item.radius
    if not near.any():
        raise RobotFileError(
            f"{source}: {one.where}.radius: no node of region lies within {one.item.radius:g} m of the axis"
        )
    tied: Ints = nodes[near]
    return tied
