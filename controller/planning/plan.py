"""The plan of a decision: the QPCC (T1) over the horizon, posed, solved and checked.

The plan is an implicit step as long as the horizon from the present state. It ends where the robot comes to
rest, but for the inertia that a horizon leaves: so a plan weighs directions by stiffness and not by inertia,
and neither chases a target out of reach nor excites vibrations. The positions that it may ask for are those
that the actuators reach within one tick; a step of that size is what the linearisation is good for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from tauten.controller.friction import (
    CutPlan,
    PlanSearch,
    pushed_slots,
    with_slip,
)
from tauten.controller.planning.energy import capped_scales, energy_scales, scale_of_all
from tauten.controller.planning.horizon import Horizon
from tauten.controller.planning.inverse import (
    Aim,
    exact_problem,
    held_back,
    including_hold,
    inverse_problem,
    weighed,
    weighted_rows,
    with_efforts_limited,
    with_force_limits,
)
from tauten.controller.planning.locks import LockedStep
from tauten.controller.planning.settings import DecideSettings
from tauten.controller.qpcc import (
    Certificate,
    Qpcc,
    QpccSettings,
    Solution,
    Start,
    Status,
    solve_qpcc,
    solve_relaxed,
)
from tauten.model import (
    Clusters,
    Command,
    Compliance,
    CondensedStep,
    Enrichment,
    Forces,
    PredictedStep,
    Robot,
    forward_step,
    predict,
    under_friction,
    unit_start,
)
from tauten.model.numerics import Array, Bools, Ints

EXACTLY = 1e-7  # of the size of the largest part, within which an exact effector meets its target
EMPTY = (Status.INFEASIBLE, Status.NOT_FOUND)  # of a QPCC whose limits are relaxed


@dataclass(frozen=True, slots=True)
class Prepared:
    """All of a step but the target.

    Attributes:
        step: of one tick: system, rows, compliance of effectors, cables, reduced contacts, unit columns.
        held: the step over the horizon in which the actuators keep what they have; plans start from it.
        forces: of the last step, where the solvers of the tick start.
        scales: of the actuation energy in each cluster (c,), s in (T1) [m/N].
        clusters: what of the robot acts on each other.
        farther: the step over the horizon with the friction of its contacts, from which `held` differs
            where there is any: plans have the friction of the last step as a load.
    """

    step: CondensedStep
    held: PredictedStep
    forces: Forces
    scales: Array
    clusters: Clusters
    farther: CondensedStep


@dataclass(frozen=True, slots=True)
class Situation:
    """What a plan starts from and what bounds it.

    Attributes:
        robot: limits, time step, weights of the effectors.
        prepared: the step.
        position: (n_a,) positions of the actuators commanded last [m].
        settings: weights and tolerances.
        locks: what locked actuators keep; None: all are decided.
    """

    robot: Robot
    prepared: Prepared
    position: Array
    settings: DecideSettings
    locks: Command | None


@dataclass(frozen=True, slots=True)
class Plan:
    """A solved plan.

    Attributes:
        predicted: forces and motion over the horizon, with the unit columns that joined.
        status: how the solver ended.
        certificate: of the solution.
        conflict: names of the limits that conflict.
        problem: the QPCC that was solved last.
        start: where its solver started.
        held_to: (n_e,) effector rows that γ holds it back to.
        cuts: where its searches were cut, by the number of the cluster; None: it was not.
        pushed: slots of the unit columns that push in it, with friction.
    """

    predicted: PredictedStep
    status: Status
    certificate: Certificate
    conflict: tuple[str, ...]
    problem: Qpcc
    start: Start
    held_to: Array
    cuts: tuple[CutPlan | None, ...]
    pushed: Ints


def prepared_plans(
    horizon: Horizon,
    step: CondensedStep,
    farther: CondensedStep,
    forces: Forces,
    keep: Command,
    enrichment: Enrichment,
) -> Prepared:
    """All of a step but the target, from its condensed rows."""
    robot, clusters = horizon.robot, horizon.clusters
    held = held_ahead(farther, forces, keep, enrichment)
    found, layout = held.step.compliance, held.step.layout
    W, _ = weighted_rows(found.W, found.delta_free, robot.effector_layout.scale)
    pushing = held.lam[layout.contacts] > 0.0
    if held.step.frictional:  # tangents never push
        gaps = np.zeros_like(pushing)
        gaps[held.step.gap_rows - layout.contacts.start] = True
        pushing &= gaps
    scales = energy_scales(W, layout, pushing, robot.actuators.groups, clusters)
    return Prepared(step, held, forces, scales, clusters, farther)


def held_ahead(
    farther: CondensedStep, forces: Forces, keep: Command, enrichment: Enrichment
) -> PredictedStep:
    """The step over the horizon in which the actuators keep what they have.

    With friction, unless no forces within the cones are found: then that of the last step is a load.
    """
    solved = forward_step(farther, enrichment, forces, keep)
    if solved.converged or not farther.frictional:
        return solved
    return forward_step(under_friction(farther, forces), enrichment, forces, keep)


def plan_from(situation: Situation, aim: Aim, step: CondensedStep, h: float) -> Plan:
    """A plan from a step over the horizon with its first unit columns.

    Args:
        situation: what it starts from and what bounds it.
        aim: targets of the effector rows.
        step: over the horizon.
        h: time for which the actuators move [s].
    """
    robot, prepared, settings = situation.robot, situation.prepared, situation.settings
    position, locks = situation.position, situation.locks
    held, layout, clusters = prepared.held, prepared.held.step.layout, prepared.clusters
    scales, W_aa = prepared.scales, step.compliance.W[layout.actuators, layout.actuators]
    if step.frictional:
        scales = capped_scales(scales, W_aa, robot.limits, robot.part_size, clusters)
    scale, held_to = scale_of_all(scales, clusters, aim.scale), _held_back_to(prepared, aim)
    counted, target, back = weighed(aim, held_to, clusters, scales, scale)
    weight = settings.epsilon * scale
    kept = held.delta[layout.actuators]
    left, guess, before = settings.enrichment.rounds, None, aim.cut
    while True:
        reduced = None if locks is None else LockedStep(step, locks)
        effort, pushing = _start(held, step)
        rows: LockedStep | Compliance = step.compliance
        limits, actuators, travelled, stay = robot.limits, robot.actuators, position, kept
        free, places, start = np.arange(robot.n_a), layout, Start(effort, pushing)
        if reduced is not None:
            rows, free, places = reduced, reduced.free, reduced.layout
            limits, actuators = robot.limits.at(free), robot.actuators.at(free)
            travelled, stay = position[free], kept[free]
            start = reduced.start(effort, pushing)
        W, delta_free = weighted_rows(rows.W, rows.delta_free, counted)
        at = delta_free[places.actuators]
        problem = inverse_problem(W, delta_free, target, travelled, limits, h, weight, actuators)
        problem = held_back(problem, W, places, weight * back[free], start.lam_a)
        problem = including_hold(problem, stay - at)
        problem = with_efforts_limited(problem, step, free, at, limits, actuators)
        if reduced is not None:
            problem = reduced.bounded(problem, robot.limits, robot.actuators)
        elastic = not any(aim.equations.tolist())
        if not elastic:
            met, error = counted * aim.target, EXACTLY * robot.part_size
            chosen, kinds = np.flatnonzero(aim.equations), robot.effector_layout
            problem = exact_problem(problem, W, delta_free, met, chosen, kinds, error)
        if step.frictional:
            problem = with_slip(problem, step, prepared.forces, float(counted.max()), aim.looking)
        others = len(problem.G)
        problem = with_force_limits(problem, aim.grasp, step, held)
        if step.frictional and len(step.extra) > 0:
            forces, a = _forces_of_hold(prepared, step), places.actuators
            forces = forces if reduced is None else reduced.with_cables(effort, forces)
            counted_on = settings.friction_share * step.friction
            begun = None if before is None else before.on(step, free, len(problem.m))
            search = PlanSearch(
                counted_on, start.lam_a, forces, robot.part_size, weight * W[a, a], settings.search,
                guess, begun,
            )  # fmt: skip
            problem, solution = solve_relaxed(problem, others, search, EMPTY[:1] if elastic else ())
            guess, columns = solution if solution.status.usable else None, len(prepared.forces.beta)
            cut = None if search.cut is None else CutPlan.of(search.cut, step, free, columns)
            before = cut
        else:
            cut = None
            solve = partial(_without_friction, start, settings.qpcc)
            problem, solution = solve_relaxed(problem, others, solve, EMPTY if elastic else ())
        if reduced is not None:
            lam = reduced.forces(solution)
        else:
            lam = np.concatenate([np.zeros(layout.n_e), solution.lam_a, solution.beta])
        found = predict(step, settings.enrichment, lam, left > 0 and solution.status.usable)
        if isinstance(found, PredictedStep):
            ended = solution.status, solution.certificate, solution.conflict
            return Plan(found, *ended, problem, start, held_to, (cut,), pushed_slots(found))
        step, left = found, left - 1


def _forces_of_hold(prepared: Prepared, step: CondensedStep) -> Array:
    """Contact forces (s + 3 k,) of a hold with all of the friction; where there are none, of the last step.

    Over the horizon the forces of the last step are those of another motion: from them the forces of the hold
    with a share of the friction are not always found.

    Args:
        prepared: the step.
        step: that of the hold, or with more unit columns.
    """
    held, forces = prepared.held, np.zeros(len(step.compliance) - step.layout.contacts.start)
    if held.step.frictional:
        known = held.lam[held.step.layout.contacts]
        forces[: len(known)] = known
    else:
        units = unit_start(step, prepared.forces)
        forces[len(forces) - len(units) :] = units
    return forces


def _held_back_to(prepared: Prepared, aim: Aim) -> Array:
    """The effector rows (n_e,) that γ holds a plan back to: those of holding, or as they are now.

    Where contacts with friction give way in a hold, an object falls; that is no motion to hold back to.

    Args:
        prepared: the step.
        aim: targets and weights of the rows.
    """
    held, now = prepared.held.delta[: len(aim.scale)], prepared.step.rows.effectors.delta
    if not prepared.farther.frictional:
        return held
    lost = _length(aim.scale * (held - aim.target)) > _length(aim.scale * (now - aim.target))
    return now if lost else held


def distance_left(aim: Aim, predicted: PredictedStep) -> float:
    """How far a step leaves the effectors from their target, as they are weighted [m]."""
    rows = predicted.delta[predicted.step.layout.effectors]
    return _length(aim.scale * (rows - aim.target))


def _length(rows: Array) -> float:
    """Length of rows (n_e,), also of those whose squares overflow."""
    return math.hypot(*rows.tolist())


def _start(held: PredictedStep, step: CondensedStep) -> tuple[Array, Bools]:
    """Efforts (n_a,) and pushing contacts of a hold, where the solver starts; new columns do not push."""
    layout = step.layout
    pushing = np.zeros(len(step.compliance.delta_free) - layout.contacts.start, np.bool_)
    if step.frictional is held.step.frictional:
        known = held.lam[layout.contacts] > 0.0
        pushing[: len(known)] = known
    return held.lam[layout.actuators], pushing


def _without_friction(
    start: Start, settings: QpccSettings, problem: Qpcc, near: Solution | None
) -> Solution:
    """Solve a QPCC from its start, or from the nearest point to the limits."""
    begin = start if near is None else Start(near.lam_a, near.piece)
    return solve_qpcc(problem, begin, settings)
