"""Which rows of a robot act on each other, and which never do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from tauten.model.numerics import Bools, Ints
from tauten.model.points import Entries
from tauten.model.robot.robot import Robot
from tauten.model.rows import Jacobian, dense


@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """Effectors and actuators that bodies or contact may join, and that nothing joins with others.

    Attributes:
        effectors: (r,) numbers of their rows among the effector rows.
        values: (g,) numbers of their goal values.
        actuators: (a,) numbers.
        rows: (r + a,) numbers of both among the rows of a step, in which effectors come first.
    """

    effectors: Ints
    values: Ints
    actuators: Ints
    rows: Ints


@dataclass(frozen=True, slots=True, eq=False)
class Clusters:
    """All clusters of a robot.

    Attributes:
        each: the clusters.
        of_effectors: (n_e,) number of the cluster of each effector row.
        of_actuators: (n_a,), of each actuator,
        of_pairs: (q,) of each contact,
        of_parts: (p,) and of each part, −1 where it is in none or several; none where there are no parts.
        rubbing: (c,) which of them have contacts with friction; all of them where no contact has.
    """

    each: tuple[Cluster, ...]
    of_effectors: Ints
    of_actuators: Ints
    of_pairs: Ints
    of_parts: Ints
    rubbing: Bools


def clusters_of(robot: Robot) -> Clusters:
    """The clusters of a robot: one, unless it has parts or bodies that nothing joins.

    All bodies of a contact are joined, however far they are apart now.
    """
    number, layout = robot.body.components, robot.effector_layout  # (n,)
    rows = robot.rows(robot.rest(), contacts=False)
    of_rows, actuators = _touched(rows.effectors.H, number), _touched(rows.actuators.H, number)
    effectors = [of_rows[layout.rows_of(i)].any(axis=0) for i in range(len(layout))]
    pressed = _pressed(robot, number)
    limits = [pressed[[*one.pairs]].any(axis=0) for one in robot.contacts.sums]
    joins = np.array([*effectors, *actuators, *pressed, *limits], dtype=float)  # (j, s)
    _, label = connected_components(sp.csr_array(joins.T @ joins), directed=False)  # (s,)
    of_effector = label[[one.argmax() for one in effectors]] if effectors else label[:0]
    of_actuator = label[actuators.argmax(axis=1)]
    counts = np.diff(layout.row_starts), np.diff(layout.value_starts)
    of_row, of_value = (np.repeat(of_effector, count) for count in counts)
    kept, every = np.unique(np.concatenate([of_row, of_actuator]), return_inverse=True)
    each = tuple(
        Cluster(
            np.flatnonzero(of_row == found),
            np.flatnonzero(of_value == found),
            np.flatnonzero(of_actuator == found),
            np.flatnonzero(every == place),
        )
        for place, found in enumerate(kept)
    )
    places = {found: place for place, found in enumerate(kept.tolist())}

    def within(sets: Bools | Ints) -> int:
        found = np.unique(label[sets]).tolist()
        return places.get(found[0], -1) if len(found) == 1 else -1

    of_pairs = np.array([within(sets) for sets in pressed], np.int64)
    parts = [np.unique(number[robot.body.unknowns_of(name)]) for name in robot.body.part_names]
    of_parts = np.array([within(sets) for sets in parts], np.int64)
    friction = np.array([pair.friction for pair in robot.contacts.pairs])
    rubbing = np.isin(np.arange(len(each)), of_pairs[friction > 0.0])
    rubbing |= not rubbing.any()
    return Clusters(each, every[: len(of_row)], every[len(of_row) :], of_pairs, of_parts, rubbing)


def _touched(H: Jacobian, number: Ints) -> Bools:
    """Whether rows (m, n) act on sets of unknowns, of numbers (n,): (m, s)."""
    found = np.zeros((H.shape[0], int(number.max()) + 1), np.bool_)
    row, column = np.nonzero(dense(H))
    found[row, number[column]] = True
    return found


def _pressed(robot: Robot, number: Ints) -> Bools:
    """Whether candidates or target of each contact are on sets of unknowns, of numbers (n,): (q, s)."""
    points = [np.union1d(one.nodes, one.triangles) for one in robot.contacts.pairs]
    starts = np.cumsum([0, *map(len, points)])
    every = np.concatenate([np.zeros(0, np.int64), *points]).astype(np.int64)
    placed = robot.body.motion(robot.rest()).placed(robot.vertices)
    return _touched(placed.rows(Entries(starts, every, np.ones((len(every), 3)))), number)
