"""What a decision takes over from those before it: how much it holds back, what is grasped, where it was cut.

How much it holds back is adapted from step to step: the weight γ on the change of the effectors, and the
share of the way to the plan that actuators go in a tick.

(T1) with γ > 0 is a damped Gauss-Newton step: the change of effectors and efforts counts γ times as much as
their values. Where a target is out of reach, the curvature of the effectors'
paths that a linearised step leaves out is as large as what it contains; an undamped step overshoots, and the
next one comes back. Let d be the change of the effectors that a decision predicts, compared with what holding
would do. A change that reverses the one before shows an overshoot: γ grows. One that repeats it shows that
nothing stands in the way of larger steps: γ decreases, to zero while a moving target is followed. Changes
that become smaller and smaller converge, and γ remains.

Where a cable is taut in one plan and slack in the next, plans jump between two pieces of the problem, and no
γ ends that: commands go to and fro from tick to tick, for ever. While the target is constant, actuators then
go a smaller share of the way, half of the last where two ways in a row turn back, so that they end between.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.controller.friction import CutPlan
from tauten.model import ContactForces, ContactSpace, ForceLimits, Grasp, PredictedStep
from tauten.model.numerics import Array

REVERSED = 0.1  # d_k·d_(k-1) / |d_(k-1)|² below which a change counts as an overshoot,
REPEATED = 0.6  # and above which as one of a series
LARGEST_GROWTH = 2.0  # of 1 + γ in a step
DECREASE = 0.8
LARGEST = 100.0  # γ
BACK = (-2.0, -0.5)  # w_k·w_(k-1) / |w_(k-1)|² of ways commanded, between which one turns back
GROWTH = 1.1  # of the share of the way where a way repeats the one before
STILL = 1e-9  # of the robot's size; smaller changes are rounding


@dataclass(frozen=True, slots=True)
class Damping:
    """How much a decision holds back.

    Attributes:
        gamma: γ, weight on the change of the effectors relative to that on their distance from the target.
        change: (n_e + n_a,) predicted change d of the decision before, of effector rows and efforts as (T1)
            weighs them [m]; empty: none.
        share: of the way to the plan that actuators go in a tick, 0 to 1.
        way: (n_a,) that actuators went in the tick before, as multiples of what rates allow; empty: none.
        turned: whether that way turned back.
        goal: (n_v,) of the decision before; empty: none.
    """

    gamma: float
    change: Array
    share: float
    way: Array
    turned: bool
    goal: Array

    def towards(self, goal: Array) -> Damping:
        """The damping of a decision for a goal (n_v,): all of the way where it is another one than before."""
        if np.array_equal(goal, self.goal):
            return self
        return replace(self, share=1.0, way=np.zeros(0), turned=False, goal=goal)


def undamped() -> Damping:
    """The start."""
    none = np.zeros(0)
    return Damping(0.0, none, 1.0, none, False, none)


def adapted(damping: Damping, change: Array, size: float, way: Array) -> Damping:
    """The damping of the next decision.

    Args:
        damping: of this one, see `Damping.towards`.
        change: (n_e + n_a,) that this one predicts [m].
        size: of the robot [m].
        way: (n_a,) that actuators go in this tick, as a multiple of what their rates allow.
    """
    before, gamma = damping.change, damping.gamma
    if len(before) == len(change) and float(before @ before) > (STILL * size) ** 2:
        repeated = float(change @ before) / float(before @ before)
        if repeated < REVERSED:
            growth = min(1.0 + REVERSED - repeated, LARGEST_GROWTH)
            gamma = min((1.0 + gamma) * growth - 1.0, LARGEST)
        elif repeated > REPEATED:
            gamma = max((1.0 + gamma) * DECREASE - 1.0, 0.0)
    share, turned = _next_share(damping, way)
    return Damping(gamma, change, share, way, turned, damping.goal)


def _next_share(damping: Damping, way: Array) -> tuple[float, bool]:
    """The share of the way in the next tick, and whether the way (n_a,) of this one turned back."""
    before, share = damping.way, damping.share
    if len(before) != len(way) or not before.any():
        return share, False
    repeated = float(way @ before) / float(before @ before)
    turned = BACK[0] < repeated < BACK[1]
    if turned and damping.turned:
        share *= 0.5
    elif repeated > REPEATED:
        share = min(GROWTH * share, 1.0)
    return share, turned


@dataclass(frozen=True, slots=True)
class Carried:
    """What a decision takes over from those before it.

    Attributes:
        damping: how much it holds back.
        grasp: limits of contact forces, and which of them count; None: there are none.
        cut: where the search of the last plan with friction was cut; None: it was not.
    """

    damping: Damping
    grasp: Grasp | None
    cut: CutPlan | None = None

    def exceeded(self, step: PredictedStep, space: ContactSpace) -> tuple[str, ...]:
        """The names of the limits that the contact forces of a step are beyond."""
        return () if self.grasp is None else self.grasp.exceeded(step.touching(space))

    def letting_go(self, found: ContactForces) -> Carried:
        """The same where all is let go that pushes in a step with these forces."""
        return self if self.grasp is None else replace(self, grasp=self.grasp.letting_go(found))


def nothing_carried(limits: ForceLimits | None) -> Carried:
    """The start of a robot with these limits of contact forces; None: it has none."""
    return Carried(undamped(), None if limits is None else Grasp.at_start(limits))
