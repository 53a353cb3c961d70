"""The course of the goals of the last ticks: how the targets move, and how the effectors follow them."""

from __future__ import annotations

import math

import numpy as np

from tauten.model import Clusters, EffectorLayout
from tauten.model.numerics import Array

ENOUGH = 0.5  # of the effectors' motion, that the targets make where all of it goes on
LATE = 4.0  # ticks of that motion from the targets, where nothing goes on; a tick less: all of it


def with_goal(course: Array, goal: Array | None, ticks: int) -> Array:
    """The goals of the last ticks: (s, n_v), oldest first, up to one more than half of the horizon.

    Args:
        course: (r, n_v) those before; without entries: none.
        goal: (n_v,) the last one; None: there was none, which begins another course.
        ticks: of the horizon.
    """
    if goal is None:
        return np.zeros((0, 0))
    kept = course.reshape(-1, len(goal))[-max(ticks // 2, 1) :]
    joined: Array = np.concatenate([kept, goal[None]])
    return joined


def shares_that_go_on(
    course: Array,
    layout: EffectorLayout,
    values: Array,
    moved: Array,
    clusters: Clusters,
    most: float = 1.0,
) -> Array:
    """The shares s of the velocity of every cluster (c,), each 0 to 1.

    Args:
        course: (s, n_v) goals of the last ticks, see `with_goal`.
        layout: of the effectors.
        values: (n_v,) present values of the effectors.
        moved: (n_e,) change of the effector rows in a tick by the velocity of the robot.
        clusters: of the robot.
        most: the largest share.
    """
    ticks = len(course) - 1
    if ticks < 1:
        return np.zeros(len(clusters.each))
    error = layout.scale * layout.difference(course[-1], values)  # (n_e,) m
    own = layout.scale * moved  # (n_e,) m
    target = layout.scale * layout.difference(course[-1], course[0])
    rows = [one.effectors for one in clusters.each]
    return np.array([_share_of(error[of], own[of], target[of], ticks, most) for of in rows])


def _share_of(error: Array, moved: Array, target: Array, ticks: int, most: float) -> float:
    """The share of one cluster.

    Args:
        error: (r,) of its rows from the last target [m].
        moved: (r,) their change in a tick by the velocity of the robot [m].
        target: (r,) change of their targets [m],
        ticks: in so many ticks.
        most: the largest share.
    """
    tick = float(np.linalg.norm(moved))
    # targets may be so far that squares overflow
    if not np.abs(error).max(initial=0.0) < LATE * tick:
        return 0.0
    distance = float(np.linalg.norm(error))
    if not distance < LATE * tick:
        return 0.0
    following = min(LATE - distance / tick, 1.0)
    own = moved * ticks
    way = ENOUGH * float(own @ own)
    along = float(np.clip(target, -1e6 * tick, 1e6 * tick) @ own)  # as above
    return following * float(np.clip(along / way, 0.0, most))


def time_behind(course: Array, layout: EffectorLayout, values: Array, h: float) -> float:
    """How long the effectors are behind targets that move [s]; infinite where these stay, or have jumped.

    The targets' speed is the lower one of the two halves of the course.

    Args:
        course: (s, n_v) goals of the last ticks, see `with_goal`.
        layout: of the effectors.
        values: (n_v,) present values of the effectors.
        h: length of a tick [s].
    """
    middle = (len(course) - 1) // 2
    if middle < 1:
        return math.inf
    error = layout.scale * layout.difference(course[-1], values)  # (n_e,) m
    before = layout.scale * layout.difference(course[middle], course[0])
    after = layout.scale * layout.difference(course[-1], course[middle])
    distance, *ways = (math.hypot(*row.tolist()) for row in (error, before, after))
    speed = min(ways[0] / middle, ways[1] / (len(course) - 1 - middle)) / h  # m/s
    return distance / speed if speed > 0.0 else math.inf
