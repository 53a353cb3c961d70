"""Nodes of a robot file that are glued to tetrahedra, and what an attachment selects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tauten.model.constraints import GluedNodes, PinnedRegion
from tauten.model.load.bodies import Bodies
from tauten.model.load.joins import AnyFrame, Attachment, axis_of
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Ints
from tauten.model.schema import AttachmentSettings, RobotFileError


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
        whole = any(one.chosen[f.nodes].all() for f in frames if isinstance(f, PinnedRegion))
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
