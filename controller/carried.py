"""What a decision takes over from those before it: how much it holds back, what is grasped, where it was cut.

How much it holds back is adapted from step to step: the weight γ on the change of the effectors, and the
share of the way to the plan that actuators go in a tick.

(T1) with γ > 0 is a damped Gauss-Newton step: the change of effectors and efforts counts γ times as much as
their values. Where a target is out of reach, the curvature of the effectors' paths that a linearised step
leaves out is as large as what it contains; an undamped step overshoots, and the next one comes back. Let d be
the change of the effectors that a decision predicts, compared with what holding would do, or with where they
are if friction would not hold them. A change that reverses the one before shows an overshoot: γ grows. One
that repeats it shows that nothing stands in the way of larger steps: γ decreases, to zero while a moving
target is followed. Changes that become smaller and smaller converge, and γ remains.

Where a cable is taut in one plan and slack in the next, plans jump between two pieces of the problem, and no
γ ends that: commands go to and fro for ever. While the target is constant, actuators therefore go a share of
the way that is adapted as trust regions are (Conn, Gould and Toint, Trust-Region Methods, 2000): by how much
the objective of holding has decreased over the last ticks, of what plans have predicted. A share with which
it has not decreased is too large where the robot comes to rest: the share grows to half of it at most. They
go all of the way again where the target or a lock has changed, and as far as they may where much more can be
gained than before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from tauten.controller.friction import CutPlan, no_slots
from tauten.controller.plan import Aim, Plan, Prepared
from tauten.model import ContactForces, ContactSpace, ForceLimits, Grasp, PredictedStep
from tauten.model.numerics import Array, Ints

REVERSED = 0.1  # d_k·d_(k-1) / |d_(k-1)|² below which a change counts as an overshoot,
REPEATED = 0.6  # and above which as one of a series
GRID = 1024  # that ratio is a multiple of 1 / GRID: a small change has few digits that are not rounding
LARGEST_GROWTH = 2.0  # of 1 + γ in a step
DECREASE = 0.8
LARGEST = 100.0  # γ
POOR = 0.1  # of the predicted decrease: where less is reached, the share of the way shrinks,
GOOD = 0.5  # and where more is reached, it grows
SHRINKAGE, GROWTH = 0.7, 1.1  # of the share of the way in a tick
LOWERED = 0.5  # of a share with which decreases become poor, that it may grow to again;
ALLOWED = 0.1  # it may always grow to this one
SMALL = 1e-3  # share of the way below which it becomes the largest one again
MORE = 2.0  # where the gain is this multiple of its mean
RECENT = 0.2  # weight of the last tick in the mean of decreases
JUMP = 1e-4  # of the robot's size: a goal that changes by more in a tick is another one
STILL = 1e-9  # of the robot's size; smaller changes are rounding


@dataclass(frozen=True, slots=True)
class Objective:
    """The objective of (T1) at the end of the horizon.

    Attributes:
        holding: where all actuators hold [m²].
        before: the same for the goal of the decision before [m²].
        planned: where they go to the plan [m²].
        share: of the way there that they go in the tick.
    """

    holding: float
    before: float
    planned: float
    share: float

    @property
    def gain(self) -> float:
        """What all of the way would decrease it by [m²]."""
        return self.holding - self.planned

    @property
    def predicted(self) -> float:
        """Decrease in the tick, as the first order has it [m²]."""
        return self.share * self.gain


@dataclass(frozen=True, slots=True)
class Damping:
    """How much a decision holds back.

    Attributes:
        gamma: γ, weight on the change of the effectors relative to that on their distance from the target.
        change: (n_e + n_a,) predicted change d of the decision before, of effector rows and efforts as (T1)
            weighs them [m]; empty: none.
        share: of the way to the plan that actuators go in a tick, 0 to 1.
        most: largest share.
        grown: whether the share has not shrunk since it grew.
        objective: of the decision before; None: the goal has jumped.
        actual: mean decrease of the objective of holding in a tick [m²].
        predicted: mean of what plans predicted [m²].
        gain: mean of what all of the way would decrease it by [m²].
        goal: (n_v,) of the decision before; empty: none.
    """

    gamma: float
    change: Array
    share: float
    most: float
    grown: bool
    objective: Objective | None
    actual: float
    predicted: float
    gain: float
    goal: Array

    def towards(self, goal: Array, size: float) -> Damping:
        """The damping of a decision for a goal (n_v,): all of the way where it has jumped.

        Args:
            goal: of the decision.
            size: of the robot [m].
        """
        before = self.goal
        if len(before) != len(goal) or np.abs(goal - before).max() > JUMP * size:
            return self.starting(goal)
        return replace(self, goal=goal)

    def starting(self, goal: Array) -> Damping:
        """The same for a goal (n_v,) that nothing is known of: all of the way."""
        return Damping(self.gamma, self.change, 1.0, 1.0, True, None, 0.0, 0.0, 0.0, goal)


def undamped() -> Damping:
    """The start."""
    none = np.zeros(0)
    return Damping(0.0, none, 1.0, 1.0, True, None, 0.0, 0.0, 0.0, none)


def adapted(damping: Damping, change: Array, size: float, objective: Objective) -> Damping:
    """The damping of the next decision.

    Args:
        damping: of this one, see `Damping.towards`.
        change: (n_e + n_a,) that this one predicts [m].
        size: of the robot [m].
        objective: that this one predicts.
    """
    before, gamma = damping.change, damping.gamma
    if len(before) == len(change) and float(before @ before) > (STILL * size) ** 2:
        repeated = round(GRID * float(change @ before) / float(before @ before)) / GRID
        if repeated < REVERSED:
            growth = min(1.0 + REVERSED - repeated, LARGEST_GROWTH)
            gamma = min((1.0 + gamma) * growth - 1.0, LARGEST)
        elif repeated > REPEATED:
            gamma = max((1.0 + gamma) * DECREASE - 1.0, 0.0)
    last, share, most, grown = damping.objective, damping.share, damping.most, damping.grown
    gain, still = objective.gain, (STILL * size) ** 2
    if last is None:
        return replace(damping, gamma=gamma, change=change, objective=objective, gain=gain)
    if share < SMALL and gain > MORE * damping.gain + still:
        return replace(damping.starting(damping.goal), share=most, most=most)
    actual = damping.actual + RECENT * (last.holding - objective.before - damping.actual)
    predicted = damping.predicted + RECENT * (last.predicted - damping.predicted)
    if predicted > still:
        if actual < POOR * predicted:
            if grown:
                most = min(most, max(LOWERED * share, ALLOWED))
            share, grown = min(SHRINKAGE * share, most), False
        elif actual > GOOD * predicted:
            share, grown = min(GROWTH * share, most), True
    mean = damping.gain + RECENT * (gain - damping.gain)
    return Damping(
        gamma, change, share, most, grown, objective, actual, predicted, mean, damping.goal
    )


def effort_scale(prepared: Prepared, weight: float) -> Array:
    """What makes efforts (n_a,) lengths as (T1) weighs them [m/N].

    Args:
        prepared: the step.
        weight: of the energy, ε s [m/N].
    """
    step = prepared.held.step
    scale: Array = np.sqrt(weight * step.compliance.W.diagonal()[step.layout.actuators])
    return scale


def change_of(prepared: Prepared, plan: Plan, aim: Aim, root: Array) -> Array:
    """How a plan differs from holding: (n_e + n_a,) [m], effector rows and efforts as (T1) weighs them.

    Args:
        prepared: the step.
        plan: over the horizon.
        aim: targets and weights of the effector rows.
        root: (n_a,) of `effort_scale`.
    """
    held, planned = prepared.held, plan.predicted
    there = planned.delta[held.step.layout.effectors]  # (n_e,)
    moved = aim.scale * (there - plan.held_to)
    pulled = root * (planned.effort - held.effort)
    return np.concatenate([moved, pulled])


def objective_of(
    prepared: Prepared, plan: Plan, aim: Aim, before: Array, root: Array, way: Array
) -> Objective:
    """What a plan predicts beside holding.

    Args:
        prepared: the step.
        plan: over the horizon.
        aim: targets and weights of the effector rows.
        before: (n_e,) targets of the goal of the decision before.
        root: (n_a,) of `effort_scale`.
        way: (n_a,) of the actuators in the tick [m].
    """
    layout, held, planned = prepared.held.step.layout, prepared.held, plan.predicted
    effectors, actuators = layout.effectors, layout.actuators
    here, there = held.delta[effectors], planned.delta[effectors]
    effort, ahead = (root * held.effort).tolist(), (root * planned.effort).tolist()
    whole = math.dist(planned.delta[actuators].tolist(), held.delta[actuators].tolist())
    lengths = (  # whose squares may be infinite
        math.hypot(*(aim.scale * (here - aim.target)).tolist(), *effort),
        math.hypot(*(aim.scale * (here - before)).tolist(), *effort),
        math.hypot(*(aim.scale * (there - aim.target)).tolist(), *ahead),
    )
    squares = [length * length for length in lengths]
    share = min(math.hypot(*way.tolist()) / max(whole, 1e-300), 1.0)
    return Objective(squares[0], squares[1], squares[2], share)


@dataclass(frozen=True, slots=True)
class Carried:
    """What a decision takes over from those before it.

    Attributes:
        damping: how much it holds back.
        grasp: limits of contact forces, and which of them count; None: there are none.
        cut: where the search of the last plan with friction was cut; None: it was not.
        pushed: slots of the unit columns that pushed in that plan: they are known to the next one.
    """

    damping: Damping
    grasp: Grasp | None
    cut: CutPlan | None = None
    pushed: Ints = field(default_factory=no_slots)

    def exceeded(self, step: PredictedStep, space: ContactSpace) -> tuple[str, ...]:
        """The names of the limits that the contact forces of a step are beyond."""
        return () if self.grasp is None else self.grasp.exceeded(step.touching(space))

    def undamped(self) -> Carried:
        """The same for a decision among other actuators: nothing is held back."""
        return replace(self, damping=undamped())

    def letting_go(self, found: ContactForces) -> Carried:
        """The same where all is let go that pushes in a step with these forces."""
        return self if self.grasp is None else replace(self, grasp=self.grasp.letting_go(found))


def nothing_carried(limits: ForceLimits | None) -> Carried:
    """The start of a robot with these limits of contact forces; None: it has none."""
    return Carried(undamped(), None if limits is None else Grasp.at_start(limits))
