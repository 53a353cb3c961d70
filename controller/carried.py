"""What a decision takes over from those before it: how much is held back, what is grasped, a cut plan."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from operator import mul

import numpy as np

from tauten.controller.damping import Dampings, Energy, Objective
from tauten.controller.friction import MET, CutPlan, no_slots
from tauten.controller.planning import Aim, Plan, Prepared, brings_nearer, distance_left
from tauten.controller.qpcc import Status
from tauten.model import (
    Cluster,
    ContactForces,
    ContactSpace,
    ForceLimits,
    Grasp,
    PredictedStep,
    Robot,
)
from tauten.model.numerics import Array, Ints

FARTHER = 2.0  # distance up to which contact is looked for in the next tick,
FARTHEST = 0.25  # and of the size of the largest part, at most: motions over it are far from linear


@dataclass(frozen=True, slots=True)
class Carried:
    """What a decision takes over from those before it.

    Attributes:
        dampings: how much it holds back; None: nothing is known.
        grasp: limits of contact forces, and which of them count; None: there are none.
        cuts: where the searches of the last plan were cut, see `Plan.cuts`.
        pushed: slots of the unit columns that pushed in that plan: they are known to the next one.
        sight: distance up to which contact is looked for, if more than the alarm distance [m].
    """

    dampings: Dampings | None
    grasp: Grasp | None
    cuts: tuple[CutPlan | None, ...] = ()
    pushed: Ints = field(default_factory=no_slots)
    sight: float = 0.0

    def exceeded(self, step: PredictedStep, space: ContactSpace) -> tuple[str, ...]:
        """The names of the limits that the contact forces of a step are beyond."""
        return () if self.grasp is None else self.grasp.exceeded(step.touching(space))

    def without_plan(self, dampings: Dampings, cuts: tuple[CutPlan | None, ...]) -> Carried:
        """The same after a decision that leads nowhere: nothing is known of what it pushed with."""
        return replace(self, dampings=dampings, cuts=cuts, pushed=no_slots())

    def undamped(self) -> Carried:
        """The same for a decision among other actuators: nothing is held back."""
        return replace(self, dampings=None)

    def letting_go(self, found: ContactForces) -> Carried:
        """The same where all is let go that pushes in a step with these forces."""
        return self if self.grasp is None else replace(self, grasp=self.grasp.letting_go(found))


def nothing_carried(limits: ForceLimits | None) -> Carried:
    """The start of a robot with these limits of contact forces; None: it has none."""
    return Carried(None, None if limits is None else Grasp.at_start(limits))


def change_of(prepared: Prepared, plan: Plan, aim: Aim, weight: Array) -> Array:
    """How a plan differs from holding: (n_e + n_a,) [m], effector rows and efforts as (T1) weighs them.

    Args:
        prepared: the step.
        plan: over the horizon.
        aim: targets and weights of the effector rows.
        weight: (n_a,) of the energy, ε s of each actuator [m/N].
    """
    held, planned, layout = prepared.held, plan.predicted, prepared.held.step.layout
    root = np.sqrt(weight * held.step.compliance.W.diagonal()[layout.actuators])  # (n_a,) [m/N]
    moved = aim.scale * (planned.delta[layout.effectors] - plan.held_to)
    pulled = root * (planned.effort - prepared.effort)
    return np.concatenate([moved, pulled])


def objective_of(
    prepared: Prepared,
    plan: Plan,
    aim: Aim,
    weight: float,
    moved: tuple[Array, Array],
    before: Array,
    last: Objective | None,
    own: Cluster,
) -> Objective:
    """What a plan predicts beside holding, in one cluster.

    Args:
        prepared: the step.
        plan: over the horizon.
        aim: targets and weights of the effector rows.
        weight: of the energy of its actuators, ε s [m/N].
        moved: (n_a,) ways of all actuators in the tick [m], and their efforts in it (n_a,) [N, Pa].
        before: (n_e,) targets of the goal of the decision before.
        last: objective of that decision; None: nothing is compared with it.
        own: the cluster.
    """
    held, planned, step = prepared.held, plan.predicted, prepared.held.step
    effectors, actuators = own.effectors, own.rows[len(own.effectors) :]
    rho = np.zeros(len(actuators)) if step.rho is None else step.rho[own.actuators]
    W = step.compliance.W[actuators[:, None], actuators]  # (a, a)
    energy = Energy(weight * W, rho, step.rows.actuators.delta[own.actuators])
    here, there, kept = held.delta[effectors], planned.delta[effectors], held.delta[actuators]
    effort = prepared.effort[own.actuators]
    later, force, rows = here, effort, step.rows.effectors
    H, h = step.system.h, prepared.step.system.h
    way, moving = moved[0][own.actuators], moved[1][own.actuators]
    if h < H and rows is prepared.step.rows.effectors:  # a step over H, linearised here
        later = here + (h / H) * (here - rows.delta[effectors])
        force = force + (h / H) * (force - moving)
    reached = planned.delta[actuators]
    spent, spent_later, spent_there = energy.of(
        np.array([effort, force, planned.effort[own.actuators]]), np.array([kept, kept, reached])
    )
    spent_before = spent
    if last is not None and last.energy is not None:
        (spent_before,) = last.energy.of(effort[None], kept[None])
    scale, target = aim.scale[effectors], aim.target[effectors]
    lengths = (  # whose squares may be infinite
        math.hypot(*(scale * (here - target)).tolist()),
        math.hypot(*(scale * (later - target)).tolist()),
        math.hypot(*(scale * (here - before[effectors])).tolist()),
        math.hypot(*(scale * (there - target)).tolist()),
    )
    away, relaxed, away_before, left = map(mul, lengths, lengths)
    share = min(
        math.hypot(*way.tolist()) / max(math.dist(reached.tolist(), kept.tolist()), 1e-300), 1.0
    )
    return Objective(
        away + spent, relaxed + spent_later, away_before + spent_before, left + spent_there, share, energy
    )  # fmt: skip


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
    clusters, cuts = prepared.clusters, dict(enumerate(plan.cuts))
    numbers, found = np.arange(len(clusters.each)), []
    for number in np.flatnonzero(clusters.rubbing).tolist():
        own = aim.among(clusters, numbers == number)
        cut = cuts.get(number) is not None
        found.append(_sight_of(robot, prepared, plan, own, sight, cut, number))
    return max(found)


def _sight_of(
    robot: Robot, prepared: Prepared, plan: Plan, aim: Aim, sight: float, cut: bool, number: int
) -> float:
    """That of the cluster of this number, whose rows `aim` counts, and whose search was cut or not."""
    alarm, step, clusters = robot.contacts.alarm_distance, prepared.farther, prepared.clusters
    W = step.compliance.W[step.layout.effectors, step.layout.actuators]  # (n_e, n_a)
    apart = distance_left(aim, prepared.held)
    if W[aim.scale > 0.0].any(axis=1).all() or apart <= MET * robot.part_size:
        return 0.0
    seeking = plan.status is Status.SEEKING_CONTACT or not step.frictional
    if seeking and not brings_nearer(robot, aim, plan, apart):
        if cut:  # the next one goes on with the same contacts
            return sight
        return min(FARTHER * max(sight, alarm), FARTHEST * robot.part_size)
    found, forces, loose = prepared.step.rows.contacts, prepared.forces, robot.contacts.loose
    now = found.rows_of(forces.extra[forces.extra_beta > 0.0])
    then = found.rows_of(plan.pushed)
    now, then = (rows[clusters.of_pairs[found.pair[rows]] == number] for rows in (now, then))
    touching = np.isin(found.pair[now], loose).any()
    return 0.0 if touching and (found.rows.delta[then] <= alarm).all() else sight
