"""What holds the bodies of a robot file, and which of them nothing holds."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from tauten.model.constraints import PinnedRegion
from tauten.model.load.beam_bodies import CORNERS, BeamPart
from tauten.model.load.bodies import Bodies
from tauten.model.load.constraints import Constraints
from tauten.model.mesh import off_a_line
from tauten.model.numerics import Bools, Ints
from tauten.model.schema import RobotConfig, RobotFileError


def loose_nodes(
    config: RobotConfig, bodies: Bodies, constraints: Constraints, joined: tuple[Ints, Ints]
) -> Bools:
    """Which nodes belong to bodies that nothing holds and that may move freely: (n_nodes,).

    Nodes that are fixed or move with a drive hold a body where three of them are not on a line. Bodies that
    are attached to each other are held together, and are free together.

    Args:
        config: the robot file.
        bodies: of it.
        constraints: of it.
        joined: what `groups_of_bodies` finds.

    Raises:
        RobotFileError: nothing holds a body that is not free, or the fixed nodes are all there are.
    """
    nodes, source = bodies.parts.mesh.nodes, bodies.selector.source
    supported = bodies.fixed.copy()
    for drive in constraints.drives:
        supported[drive.nodes] = True
    of_body, group = joined
    every, loose = config.all_bodies, np.zeros(len(nodes), dtype=bool)
    freed = {int(group[number]) for number, body in enumerate(every) if body.free}
    short = 1e-6 * bodies.parts.mesh.size
    for number, body in enumerate(every):
        held = nodes[supported & (group[of_body] == group[number])]
        if off_a_line(held, short):
            continue
        if int(group[number]) not in freed:
            whole = f"body {body.name!r}" if len(every) > 1 else "robot"
            raise RobotFileError(
                f"{source}: fixed: needs three nodes not on a line to hold the {whole}"
            )
        loose[of_body == number] = True
    if bodies.fixed.all():
        raise RobotFileError(f"{source}: fixed: holds every node, no node can move")
    free = {body.name for body in every if body.free}
    firm = [part for part in bodies.beams if part.name not in free and not loose[part.nodes].any()]
    require_no_spin(firm, bodies, constraints)
    return loose


def groups_of_bodies(bodies: Bodies, constraints: Constraints) -> tuple[Ints, Ints]:
    """The body of every node (n_nodes,), and for every body the group that it is attached to."""
    names = list(bodies.selector.ranges)
    of_body = np.zeros(len(bodies.parts.mesh.nodes), dtype=np.int64)
    for number, name in enumerate(names):
        of_body[bodies.selector.nodes_of(name)] = number
    glued = constraints.glued
    tied = [np.stack([np.repeat(glued.nodes, 4), glued.masters.ravel()])]
    for frame in constraints.frames:
        if len(frame.nodes) == 0:  # a drum
            continue
        tied.append(np.stack([frame.nodes, np.full(len(frame.nodes), frame.nodes[0])]))
    for one in constraints.pinned:
        tied.append(np.stack([np.full(len(one.masters), one.nodes[0]), one.masters]))
    pairs = of_body[np.concatenate(tied, axis=1)]
    joined = sp.coo_array((np.ones(pairs.shape[1]), pairs), shape=(len(names),) * 2)
    _, group = connected_components(joined, directed=False)
    return of_body, np.asarray(group, dtype=np.int64)


def require_no_spin(beams: list[BeamPart], bodies: Bodies, constraints: Constraints) -> None:
    """Raise a RobotFileError where a beam is held by pins on a line only, about which it may turn."""
    glued = constraints.glued
    firm, of_beams = bodies.fixed.copy(), bodies.beam_nodes
    firm[glued.masters[glued.weights != 0.0]] = True
    for frame in constraints.frames:
        alone = frame.name.startswith("bodies.") or isinstance(frame, PinnedRegion)
        own = np.intersect1d(frame.nodes, of_beams)
        if not (alone and len(own) == 1 and len(frame.nodes) == len(bodies.corners_of(own[0]))):
            firm[frame.nodes] = True  # a servo, or something that the node is part of
    for part in beams:
        if any(firm[part.nodes + corner].any() for corner in range(CORNERS)):
            continue
        pins = [one.pin for one in constraints.pinned if np.isin(one.nodes, part.nodes).any()]
        if pins and not off_a_line(np.array(pins), 1e-6 * part.body.size):
            raise RobotFileError(
                f"{bodies.selector.source}: bodies.{part.name}: its pins lie on a line, about which it turns "
                "freely; fix or glue one of its nodes, or glue something to it"
            )
