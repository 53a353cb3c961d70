"""How much a decision holds back: the weight γ on the change of the effectors, adapted from step to step.

(T1) with γ > 0 is a damped Gauss-Newton step: the change of effectors and efforts counts γ times as much as
their values. Where a target is out of reach, the curvature of the effectors'
paths that a linearised step leaves out is as large as what it contains; an undamped step overshoots, and the
next one comes back. Let d be the change of the effectors that a decision predicts, compared with what holding
would do. A change that reverses the one before shows an overshoot: γ grows. One that repeats it shows that
nothing stands in the way of larger steps: γ decreases, to zero while a moving target is followed. Changes
that become smaller and smaller converge, and γ remains.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array

REVERSED = 0.1  # d_k·d_(k-1) / |d_(k-1)|² below which a change counts as an overshoot,
REPEATED = 0.6  # and above which as one of a series
LARGEST_GROWTH = 2.0  # of 1 + γ in a step
DECREASE = 0.8
LARGEST = 100.0  # γ
STILL = 1e-9  # of the robot's size; smaller changes are rounding


@dataclass(frozen=True, slots=True)
class Damping:
    """What a decision takes over from the one before.

    Attributes:
        gamma: γ, weight on the change of the effectors relative to that on their distance from the target.
        change: (n_e + n_a,) predicted change d of the decision before, of effector rows and efforts as (T1)
            weighs them [m]; empty: none.
    """

    gamma: float
    change: Array


def undamped() -> Damping:
    """The start."""
    return Damping(0.0, np.zeros(0))


def adapted(damping: Damping, change: Array, size: float) -> Damping:
    """The damping of the next decision.

    Args:
        damping: of this one.
        change: (n_e + n_a,) that this one predicts [m].
        size: of the robot [m].
    """
    before, gamma = damping.change, damping.gamma
    if len(before) == len(change) and float(before @ before) > (STILL * size) ** 2:
        repeated = float(change @ before) / float(before @ before)
        if repeated < REVERSED:
            growth = min(1.0 + REVERSED - repeated, LARGEST_GROWTH)
            gamma = min((1.0 + gamma) * growth - 1.0, LARGEST)
        elif repeated > REPEATED:
            gamma = max((1.0 + gamma) * DECREASE - 1.0, 0.0)
    return Damping(gamma, change)
