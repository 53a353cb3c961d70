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
the objective of holding has decreased over the last ticks, of what plans have predicted. Both are the
objective of the plan before, with its weights and unknown forces: another one may increase along good plans.
A share with which it has not decreased is too large where the robot comes to rest: the share grows to half of
it at most.

A robot that relaxes changes what holding leads to, for seconds, whatever its actuators do. So the decrease is
also counted from where holding for one tick would have led, and the mean of the two that is larger counts:
where holding alone decreases the objective, that is due to a momentum that plans have given. The end
q_H = q + H v₁ of a step of implicit Euler in which actuators hold, the same for their forces, changes by

    dq_H/dt = v₁ = (q_H − q) / H,   dλ_H/dt = (λ_H − λ) / H

as the equations of a linear robot M dv/dt = f − C v − K q + hᵀ λ say, for all M, C, K and whatever moves.

Of forces that redundant actuators share plans change little, so that these would go on for seconds after the
effectors have stopped. Where a plan changes so little that it makes no difference, the share fades. Actuators
go all of the way again where the target or a lock has changed, and as far as they may where much more can be
gained than before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from operator import mul

import numpy as np

from tauten.controller.friction import MET, CutPlan, no_slots, pushed_slots
from tauten.controller.plan import Aim, Plan, Prepared, brings_nearer, distance_left
from tauten.controller.qpcc import Status
from tauten.model import ContactForces, ContactSpace, ForceLimits, Grasp, PredictedStep, Robot
from tauten.model.numerics import Array, Ints
from tauten.model.signals import EffectorLayout

REVERSED = 0.1  # d_k·d_(k-1) / |d_(k-1)|² below which a change counts as an overshoot,
REPEATED = 0.6  # and above which as one of a series
GRID = 1024  # that ratio is a multiple of 1 / GRID: a small change has few digits that are not rounding
LARGEST_GROWTH = 2.0  # of 1 + γ in a step
DECREASE = 0.8
LARGEST = 100.0  # γ
POOR = 0.1  # of the predicted decrease: where less is reached, the share of the way shrinks,
GOOD = 0.5  # and where more is reached, it grows
SHRINKAGE, GROWTH = 0.7, 1.1  # of the share of the way in a tick
SETTLED = 3e-6  # of the robot's size, a change that makes no difference:
FADING = 0.9  # of the way that is gone, in a tick
TICK = 0.02  # s, for which these are; a shorter tick takes as much less of the way to them, a longer one all
LOWERED = 0.5  # of a share with which decreases become poor, that it may grow to again;
ALLOWED = 0.1  # it may always grow to this one
SMALL = 1e-3  # share of the way below which it becomes the largest one again
MORE = 2.0  # where the gain is this multiple of its mean in two ticks
RECENT = 0.2  # weight of the last tick in the mean of decreases
JUMP = 1e-4  # of the robot's size: a goal that changes by more in a tick is another one
FARTHER = 2.0  # distance up to which contact is looked for in the next tick,
FARTHEST = 0.25  # and of the size of the largest part, at most: motions over it are far from linear
STILL = 1e-9  # of the robot's size; smaller changes are rounding


@dataclass(frozen=True, slots=True)
class Energy:
    """The energy of the actuators as the objective of one plan weighs it.

    Attributes:
        weight: (n_a, n_a) matrix ε s W_aa of the unknown forces [m²/N²].
        rho: (n_a,) stiffness along actuators in these, see `CondensedStep.efforts` [N/m].
        origin: (n_a,) positions where that stiffness pulls nothing [m].
    """

    weight: Array
    rho: Array
    origin: Array

    def of(self, efforts: Array, positions: Array) -> list[float]:
        """Twice the energy of each of some efforts (s, n_a) at positions (s, n_a), of any plan [m²]."""
        forces = efforts + self.rho * (positions - self.origin)  # (s, n_a)
        found: list[float] = (forces @ self.weight @ forces.T).diagonal().tolist()
        return found


@dataclass(frozen=True, slots=True)
class Objective:
    """Twice the objective of (T1) at the end of the horizon.

    Attributes:
        holding: where all actuators hold [m²].
        relaxed: the same a tick later, if they held in it [m²].
        before: that of holding for the goal of the decision before, with the weights of its plan [m²].
        planned: where they go to the plan [m²].
        share: of the way there that they go in the tick.
        energy: how it weighs efforts; None: it does not.
    """

    holding: float
    relaxed: float
    before: float
    planned: float
    share: float
    energy: Energy | None = None

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
        share: of the way to the plan that actuators go in a tick, 0 to 1,
        faded: and what is left of it where plans change nothing that counts, 0 to 1.
        most: largest share.
        grown: whether the share has not shrunk since it grew.
        objective: of the decision before; None: the goal has jumped.
        actual: mean decrease of the objective of holding in a tick [m²],
        apart: and from where holding for the tick would have led, see `Objective.relaxed` [m²].
        predicted: mean of what plans predicted [m²].
        gain: mean of what all of the way would decrease it by [m²].
        goal: (n_v,) of the decision before; empty: none.
    """

    gamma: float
    change: Array
    share: float
    faded: float
    most: float
    grown: bool
    objective: Objective | None
    actual: float
    apart: float
    predicted: float
    gain: float
    goal: Array

    def towards(self, goal: Array, size: float, layout: EffectorLayout) -> Damping:
        """The damping of a decision for a goal (n_v,): all of the way where it has jumped.

        Args:
            goal: of the decision.
            size: of the robot [m].
            layout: of the effectors; components without weight may be anywhere.
        """
        if len(self.goal) == len(goal):
            change = layout.units * layout.difference(goal, self.goal)
            if max(np.abs(change[layout.weights > 0.0]).tolist()) <= JUMP * size:
                return replace(self, goal=goal)
        return self.starting(goal)

    def fading(self, change: Array, size: float, h: float) -> Damping:
        """The damping of a decision whose plan changes effector rows and efforts so (n_e + n_a,) [m].

        Args:
            change: of its plan, see `change_of`.
            size: of the robot [m].
            h: length of a tick [s].
        """
        settled = float(change @ change) <= (SETTLED * size) ** 2
        faded = FADING ** part_of_tick(h) * self.faded if settled else 1.0
        return self if faded == self.faded else replace(self, faded=faded)

    def starting(self, goal: Array) -> Damping:
        """The same for a goal (n_v,) that nothing is known of: all of the way."""
        return Damping(self.gamma, self.change, 1.0, 1.0, 1.0, True, None, 0.0, 0.0, 0.0, 0.0, goal)


def undamped() -> Damping:
    """The start."""
    none = np.zeros(0)
    return Damping(0.0, none, 1.0, 1.0, 1.0, True, None, 0.0, 0.0, 0.0, 0.0, none)


def part_of_tick(h: float) -> float:
    """The power of the factors of a tick that one of length h [s] takes.

    A robot that swings is worse off for half of its period, however many ticks that has: at 1 kHz a share
    that shrinks in each of them is gone after one swing.
    """
    return min(h / TICK, 1.0)


def adapted(
    damping: Damping, change: Array, size: float, h: float, objective: Objective
) -> Damping:
    """The damping of the next decision.

    Args:
        damping: of this one, see `Damping.towards` and `Damping.fading`.
        change: (n_e + n_a,) that this one predicts [m].
        size: of the robot [m].
        h: length of a tick [s].
        objective: that this one predicts.
    """
    gamma, last = _gamma_after(damping, change, size), damping.objective
    share, most, grown = damping.share, damping.most, damping.grown
    actual, apart, predicted = damping.actual, damping.apart, damping.predicted
    gain = mean = objective.gain
    if last is not None:
        still, settled = (STILL * size) ** 2, damping.faded < 1.0
        twice = min(gain, last.gain)
        if share < SMALL and not settled and twice > MORE * damping.gain + still:
            return replace(damping.starting(damping.goal), share=most, most=most)
        power = part_of_tick(h)
        recent = power * RECENT
        actual += recent * (last.holding - objective.before - actual)
        apart += recent * (last.relaxed - objective.before - apart)
        predicted += recent * (last.predicted - predicted)
        mean = damping.gain + recent * (gain - damping.gain)
        if predicted > still and not settled:
            decrease = max(actual, apart)
            if decrease < POOR * predicted:
                if grown:
                    most = min(most, max(LOWERED * share, ALLOWED))
                share, grown = min(SHRINKAGE**power * share, most), False
            elif decrease > GOOD * predicted:
                share, grown = min(GROWTH**power * share, most), True
    return Damping(
        gamma, change, share, damping.faded, most, grown, objective, actual, apart, predicted, mean,
        damping.goal,
    )  # fmt: skip


def _gamma_after(damping: Damping, change: Array, size: float) -> float:
    """The weight γ of the next decision; arguments as of `adapted`."""
    before, gamma = damping.change, damping.gamma
    if len(before) == len(change) and float(before @ before) > (STILL * size) ** 2:
        repeated = round(GRID * float(change @ before) / float(before @ before)) / GRID
        if repeated < REVERSED:
            growth = min(1.0 + REVERSED - repeated, LARGEST_GROWTH)
            return min((1.0 + gamma) * growth - 1.0, LARGEST)
        if repeated > REPEATED:
            return max((1.0 + gamma) * DECREASE - 1.0, 0.0)
    return gamma


def change_of(prepared: Prepared, plan: Plan, aim: Aim, weight: float) -> Array:
    """How a plan differs from holding: (n_e + n_a,) [m], effector rows and efforts as (T1) weighs them.

    Args:
        prepared: the step.
        plan: over the horizon.
        aim: targets and weights of the effector rows.
        weight: of the energy, ε s [m/N].
    """
    held, planned, layout = prepared.held, plan.predicted, prepared.held.step.layout
    root = np.sqrt(weight * held.step.compliance.W.diagonal()[layout.actuators])  # (n_a,) [m/N]
    moved = aim.scale * (planned.delta[layout.effectors] - plan.held_to)
    pulled = root * (planned.effort - held.effort)
    return np.concatenate([moved, pulled])


def objective_of(
    prepared: Prepared,
    plan: Plan,
    aim: Aim,
    weight: float,
    way: Array,
    effort: Array,
    before: Array,
    last: Objective | None,
) -> Objective:
    """What a plan predicts beside holding.

    Args:
        prepared: the step.
        plan: over the horizon.
        aim: targets and weights of the effector rows.
        weight: of the energy, ε s [m/N].
        way: (n_a,) of the actuators in the tick [m].
        effort: (n_a,) of the actuators in it [N, Pa].
        before: (n_e,) targets of the goal of the decision before.
        last: objective of that decision; None: nothing is compared with it.
    """
    held, planned, step = prepared.held, plan.predicted, prepared.held.step
    effectors, actuators = step.layout.effectors, step.layout.actuators
    rho = np.zeros(len(held.effort)) if step.rho is None else step.rho
    W = step.compliance.W[actuators, actuators]
    energy = Energy(weight * W, rho, step.rows.actuators.delta)
    here, there, kept = held.delta[effectors], planned.delta[effectors], held.delta[actuators]
    later, force, rows = here, held.effort, step.rows.effectors
    H, h = step.system.h, prepared.step.system.h
    if h < H and rows is prepared.step.rows.effectors:  # a step over H, linearised here
        later = here + (h / H) * (here - rows.delta)
        force = force + (h / H) * (force - effort)
    reached = planned.delta[actuators]
    spent, spent_later, spent_there = energy.of(
        np.array([held.effort, force, planned.effort]), np.array([kept, kept, reached])
    )
    spent_before = spent
    if last is not None and last.energy is not None:
        (spent_before,) = last.energy.of(held.effort[None], kept[None])
    lengths = (  # whose squares may be infinite
        math.hypot(*(aim.scale * (here - aim.target)).tolist()),
        math.hypot(*(aim.scale * (later - aim.target)).tolist()),
        math.hypot(*(aim.scale * (here - before)).tolist()),
        math.hypot(*(aim.scale * (there - aim.target)).tolist()),
    )
    away, relaxed, away_before, left = map(mul, lengths, lengths)
    share = min(
        math.hypot(*way.tolist()) / max(math.dist(reached.tolist(), kept.tolist()), 1e-300), 1.0
    )
    return Objective(
        away + spent, relaxed + spent_later, away_before + spent_before, left + spent_there, share, energy
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Carried:
    """What a decision takes over from those before it.

    Attributes:
        damping: how much it holds back.
        grasp: limits of contact forces, and which of them count; None: there are none.
        cut: where the search of the last plan with friction was cut; None: it was not.
        pushed: slots of the unit columns that pushed in that plan: they are known to the next one.
        sight: distance up to which contact is looked for, if more than the alarm distance [m].
    """

    damping: Damping
    grasp: Grasp | None
    cut: CutPlan | None = None
    pushed: Ints = field(default_factory=no_slots)
    sight: float = 0.0

    def exceeded(self, step: PredictedStep, space: ContactSpace) -> tuple[str, ...]:
        """The names of the limits that the contact forces of a step are beyond."""
        return () if self.grasp is None else self.grasp.exceeded(step.touching(space))

    def without_plan(self, damping: Damping, cut: CutPlan | None) -> Carried:
        """The same after a decision that leads nowhere: nothing is known of what it pushed with."""
        return replace(self, damping=damping, cut=cut, pushed=no_slots())

    def undamped(self) -> Carried:
        """The same for a decision among other actuators: nothing is held back."""
        return replace(self, damping=undamped())

    def letting_go(self, found: ContactForces) -> Carried:
        """The same where all is let go that pushes in a step with these forces."""
        return self if self.grasp is None else replace(self, grasp=self.grasp.letting_go(found))


def nothing_carried(limits: ForceLimits | None) -> Carried:
    """The start of a robot with these limits of contact forces; None: it has none."""
    return Carried(undamped(), None if limits is None else Grasp.at_start(limits))


def sight_after(robot: Robot, prepared: Prepared, plan: Plan, aim: Aim, sight: float) -> float:
    """Up to which distance the next decision looks for contact [m]; 0: up to the alarm distance.

    An effector on an object moves only if something touches the object, which may be far away. Where a search
    that is not cut finds no plan that brings such effectors nearer to their targets, the next one looks twice
    as far. It looks as far as this one until bodies touch and all that push in the plan are within the alarm
    distance.

    Args:
        robot: its size, and the contacts of its parts.
        prepared: the step.
        plan: over the horizon.
        aim: targets and weights of the effector rows.
        sight: up to which this decision looked [m].
    """
    alarm, step = robot.contacts.alarm_distance, prepared.farther
    W = step.compliance.W[step.layout.effectors, step.layout.actuators]  # (n_e, n_a)
    apart = distance_left(aim, prepared.held)
    if W[aim.scale > 0.0].any(axis=1).all() or apart <= MET * robot.size:
        return 0.0
    seeking = plan.status is Status.SEEKING_CONTACT or not step.frictional
    if seeking and not brings_nearer(robot, aim, plan, apart):
        if plan.cut is not None:  # the next one goes on with the same contacts
            return sight
        return min(FARTHER * max(sight, alarm), FARTHEST * robot.part_size)
    found, forces, loose = prepared.step.rows.contacts, prepared.forces, robot.contacts.loose
    now = found.rows_of(forces.extra[forces.extra_beta > 0.0])
    then = found.rows_of(pushed_slots(plan.predicted))
    touching = np.isin(found.pair[now], loose).any()
    return 0.0 if touching and (found.rows.delta[then] <= alarm).all() else sight
