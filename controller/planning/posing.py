"""(T1) of a plan, posed: rows and efforts are weighed, and limits of all kinds join the inverse problem."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tauten.controller.friction import with_slip
from tauten.controller.planning.energy import capped_scales, relative_weights, scale_of_all
from tauten.controller.planning.inverse import (
    Aim,
    exact_problem,
    held_back,
    including_hold,
    inverse_problem,
    weighted_rows,
    with_efforts_limited,
    with_force_limits,
    without_rounding,
)
from tauten.controller.planning.locks import LockedStep
from tauten.controller.planning.prepared import Prepared, Situation
from tauten.controller.qpcc import Qpcc, Solution, Start
from tauten.model import Compliance, CondensedStep, Layout, PredictedStep
from tauten.model.numerics import Array, Bools, Ints

EXACTLY = 1e-7  # of the size of the largest part, within which an exact effector meets its target
ROUNDING = 1e-12  # of that size, of positions


@dataclass(frozen=True, slots=True)
class Weights:
    """What effector rows and efforts count in a plan.

    Attributes:
        counted: (n_e,) weights times units of the rows.
        target: (n_e,) targets of the rows times these [m].
        held_to: (n_e,) rows that γ holds a plan back to.
        energy: of the actuators, ε s [m/N].
        back: (n_a,) how far γ holds their efforts back, γ / (1 + γ) ε s [m/N].
    """

    counted: Array
    target: Array
    held_to: Array
    energy: float
    back: Array


def weights_of(situation: Situation, aim: Aim, step: CondensedStep) -> Weights:
    """What effector rows and efforts count in the plans of a step over the horizon.

    Clusters share no unknown: the objective of each is divided by its s and by its 1 + γ, so that all have
    the same weight of the energy.

    Args:
        situation: what the plan starts from and what bounds it.
        aim: targets and weights of the rows, and γ of every cluster.
        step: over the horizon.
    """
    robot, prepared = situation.robot, situation.prepared
    clusters, scales = prepared.clusters, prepared.scales
    held_to = prepared.held.delta[: len(aim.scale)]
    if step.frictional:
        actuators = step.layout.actuators
        W_aa = step.compliance.W[actuators, actuators]  # (n_a, n_a)
        scales = capped_scales(scales, W_aa, robot.limits, robot.part_size, clusters)
    if prepared.farther.frictional:
        held_to = _held_back_to(prepared, aim)
    back, counted = aim.gamma / (1.0 + aim.gamma), aim.scale  # (c,), (n_e,)
    scale = float(scales[0])
    if len(back) > 1:
        scale = scale_of_all(scales, clusters, aim.scale)
        counted = counted * relative_weights(scales, scale)[clusters.of_effectors]
    target = aim.target + back[clusters.of_effectors] * (held_to - aim.target)
    energy = situation.settings.epsilon * scale
    return Weights(
        counted=counted,
        target=counted * target,
        held_to=held_to,
        energy=energy,
        back=energy * back[clusters.of_actuators],
    )


@dataclass(frozen=True, slots=True)
class Posed:
    """(T1) of a plan.

    Attributes:
        problem: the QPCC.
        others: number of its limits before those of contact forces.
        start: where its solver starts.
        step: over the horizon.
        W: (m, m) compliance of the rows of the problem, weighed.
        layout: of these rows.
        free: (f,) numbers of the actuators that are decided.
        unlocked: the step without the rows of locked actuators; None: none is locked.
    """

    problem: Qpcc
    others: int
    start: Start
    step: CondensedStep
    W: Array
    layout: Layout
    free: Ints
    unlocked: LockedStep | None

    def forces(self, solution: Solution) -> Array:
        """Forces (m,) on all rows of the step."""
        if self.unlocked is not None:
            return self.unlocked.forces(solution)
        none = np.zeros(self.layout.n_e)
        return np.concatenate([none, solution.lam_a, solution.beta])


def pose(situation: Situation, aim: Aim, weights: Weights, step: CondensedStep, h: float) -> Posed:
    """Pose (T1) for a step.

    Args:
        situation: what the plan starts from and what bounds it.
        aim: targets of the effector rows.
        weights: what these and the efforts count.
        step: over the horizon.
        h: time for which the actuators move [s].
    """
    robot, held = situation.robot, situation.prepared.held
    effort, pushing = _start(held, step)
    hold = held.delta[held.step.layout.actuators]  # (n_a,)
    position, limits, actuators = situation.position, robot.limits, robot.actuators
    unlocked: LockedStep | None = None
    rows: LockedStep | Compliance = step.compliance
    layout, free, start = step.layout, np.arange(robot.n_a), Start(effort, pushing)
    if situation.locks is not None:
        rows = unlocked = LockedStep(step, situation.locks)
        layout, free, start = unlocked.layout, unlocked.free, unlocked.start(effort, pushing)
        position, hold = position[free], hold[free]
        limits, actuators = limits.at(free), actuators.at(free)
    W, delta_free = weighted_rows(rows.W, rows.delta_free, weights.counted)
    at = delta_free[layout.actuators]
    problem = inverse_problem(
        W, delta_free, weights.target, position, limits, h, weights.energy, actuators
    )
    problem = without_rounding(problem, ROUNDING * robot.part_size)
    if any(weights.back.tolist()):
        problem = held_back(problem, W, layout, weights.back[free], start.lam_a)
    problem = including_hold(problem, hold - at)
    problem = with_efforts_limited(problem, step, free, at, limits, actuators)
    if unlocked is not None:
        problem = unlocked.bounded(problem, robot.limits, robot.actuators)
    if any(aim.equations.tolist()):
        met, tolerance = weights.counted * aim.target, EXACTLY * robot.part_size
        exact, kinds = np.flatnonzero(aim.equations), robot.effector_layout
        problem = exact_problem(problem, W, delta_free, met, exact, kinds, tolerance)
    if step.frictional:
        largest = float(weights.counted.max())
        problem = with_slip(problem, step, situation.prepared.forces, largest, aim.looking)
    others = len(problem.G)
    if aim.grasp is not None:
        problem = with_force_limits(problem, aim.grasp, step, held)
    return Posed(problem, others, start, step, W, layout, free, unlocked)


def _start(held: PredictedStep, step: CondensedStep) -> tuple[Array, Bools]:
    """Efforts (n_a,) and pushing contacts of a hold, where the solver starts; new columns do not push."""
    layout = step.layout
    pushing = np.zeros(len(step.compliance.delta_free) - layout.contacts.start, np.bool_)
    if step.frictional is held.step.frictional:
        known = held.lam[layout.contacts] > 0.0
        pushing[: len(known)] = known
    return held.lam[layout.actuators], pushing


def _held_back_to(prepared: Prepared, aim: Aim) -> Array:
    """Rows (n_e,) that γ holds a plan with friction back to: those of holding, or as they are now.

    Where contacts give way in a hold, an object falls; that is no motion to hold back to.

    Args:
        prepared: the step.
        aim: targets and weights of the rows.
    """
    held, now = prepared.held.delta[: len(aim.scale)], prepared.step.rows.effectors.delta
    lost = _length(aim.scale * (held - aim.target)) > _length(aim.scale * (now - aim.target))
    return now if lost else held


def distance_left(aim: Aim, predicted: PredictedStep) -> float:
    """How far a step leaves the effectors from their target, as they are weighted [m]."""
    rows = predicted.delta[predicted.step.layout.effectors]
    return _length(aim.scale * (rows - aim.target))


def _length(rows: Array) -> float:
    """Length of rows (n_e,), also of those whose squares overflow."""
    return math.hypot(*rows.tolist())
