"""The plan of a decision: the QPCC (T1) over the horizon, posed, solved and checked.

The plan is an implicit step as long as the horizon from the present state. It ends where the robot comes to
rest, but for the inertia that a horizon leaves: so a plan weighs directions by stiffness and not by inertia,
and neither chases a target out of reach nor excites vibrations. The positions that it may ask for are those
that the actuators reach within one tick; a step of that size is what the linearisation is good for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from tauten.controller.energy import energy_cap, energy_scale, energy_scales
from tauten.controller.friction import (
    ALL_TRIED,
    MET,
    CutPlan,
    PlanContacts,
    PlanSearch,
    with_known_columns,
    with_slip,
)
from tauten.controller.horizon import Horizon
from tauten.controller.inverse import (
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
from tauten.controller.locks import LockedStep
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
from tauten.controller.settings import DecideSettings
from tauten.model import (
    Clusters,
    Command,
    Compliance,
    CondensedStep,
    Enrichment,
    Forces,
    Grasp,
    PredictedStep,
    Robot,
    forward_step,
    predict,
    under_friction,
    unit_start,
)
from tauten.model.numerics import Array, Bools

EXACTLY = 1e-7  # of the robot's size, within which an exact effector meets its target
ENDLESSLY = 1e6  # s, in which every actuator can get everywhere
NEAREST = 40  # candidates in range that a search for contact looks at
NEARER = 1e-3  # of the distance of the effectors from their target, that a plan takes off it
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
        cut: where its search was cut; None: it was not.
    """

    predicted: PredictedStep
    status: Status
    certificate: Certificate
    conflict: tuple[str, ...]
    problem: Qpcc
    start: Start
    held_to: Array
    cut: CutPlan | None = None


def prepared_plans(
    horizon: Horizon,
    step: CondensedStep,
    farther: CondensedStep,
    forces: Forces,
    keep: Command,
    enrichment: Enrichment,
) -> Prepared:
    """All of a step but the target, from its condensed rows."""
    held, robot, clusters = (
        held_ahead(farther, forces, keep, enrichment),
        horizon.robot,
        horizon.clusters,
    )
    found, layout = held.step.compliance, held.step.layout
    W, _ = weighted_rows(found.W, found.delta_free, robot.effector_layout.scale)
    pushing = held.lam[layout.contacts] > 0.0
    if held.step.frictional:  # tangents never push
        gaps = np.zeros_like(pushing)
        gaps[held.step.gap_rows - layout.contacts.start] = True
        pushing &= gaps
    given, count = (W, layout, pushing, robot.actuators.groups), len(clusters.each)
    if count == 1 or farther.frictional:  # slip of all contacts counts alike
        scales = np.array(count * [energy_scale(*given)])
    else:
        scales = energy_scales(*given, clusters)
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


def make_plan(
    robot: Robot,
    prepared: Prepared,
    aim: Aim,
    position: Array,
    settings: DecideSettings,
    locks: Command | None,
) -> Plan:
    """Pose and solve (T1) until no candidate in range is predicted deeper than the tolerance.

    Holding is always among what the position limits allow, so that a slack cable whose path has become
    shorter than its winch can follow stands in nobody's way. Where other limits leave nothing, those in
    conflict are relaxed as little as possible; the status is RELAXED then.

    Where contacts in range have friction, plans count on a share of it. Where such a plan brings effectors
    that are not at their target no nearer, another one with the nearest candidates in range and without rates
    looks for contact; where that finds none and a limit of contact forces is reached, the status is OK. Where
    forces within the cones are not found, the friction of the last step is a load. A search that was cut goes
    on where it was.

    Args:
        robot: limits, time step, weights of the effectors.
        prepared: the step.
        aim: targets of the effector rows.
        position: (n_a,) positions of the actuators commanded last [m].
        settings: weights and tolerances.
        locks: what locked actuators keep; None: all are decided.
    """
    resumed = aim.cut is not None and aim.cut.seeking
    first = replace(aim, cut=CutPlan(ALL_TRIED)) if resumed else aim
    given = robot, prepared, first, position, settings, locks
    if not prepared.farther.frictional:
        return _plan_from(prepared.held.step, robot.h, *given)
    step = with_known_columns(prepared.farther, prepared.held.step, aim.pushed)
    apart = distance_left(aim, prepared.held)
    plan = _plan_from(step, robot.h, *given)
    met = plan.status is Status.SEEKING_CONTACT and apart <= MET * robot.part_size
    plan = replace(plan, status=Status.OK) if met else plan
    if plan.status is Status.NOT_FOUND:
        loaded = prepared.held.step
        if loaded.frictional:
            loaded = under_friction(prepared.farther, prepared.forces)
        return _plan_from(loaded, robot.h, *given)
    untouched = len(plan.predicted.step.extra) == 0 and not brings_nearer(robot, aim, plan, apart)
    if not untouched and plan.status is not Status.SEEKING_CONTACT:
        return plan
    if not (resumed or settings.time is None or settings.time.allows()):
        return replace(plan, cut=CutPlan(None, seeking=True))
    near = np.argsort(step.rows.contacts.rows.delta, kind="stable")[:NEAREST]
    if len(near := np.setdiff1d(near, step.extra)) > 0:
        step = step.with_unit_columns(near)
    hidden = plan.status is Status.SEEKING_CONTACT
    aim = replace(aim, cut=aim.cut if resumed else None, looking=aim.looking or hidden)
    search = replace(settings, seeking=hidden)
    seeking = _plan_from(step, ENDLESSLY, robot, prepared, aim, position, search, locks)
    cut = None if seeking.cut is None else replace(seeking.cut, seeking=True)
    if seeking.status.usable and brings_nearer(robot, aim, seeking, apart):
        relaxed = seeking.status is Status.RELAXED  # of the two, what a user must know
        return replace(
            seeking, status=Status.RELAXED if relaxed else Status.SEEKING_CONTACT, cut=cut
        )
    if hidden and _presses_as_it_may(prepared, plan, aim.grasp):
        return replace(plan, status=Status.OK, cut=cut)
    return replace(plan, cut=cut)


def _plan_from(
    step: CondensedStep,
    h: float,
    robot: Robot,
    prepared: Prepared,
    aim: Aim,
    position: Array,
    settings: DecideSettings,
    locks: Command | None,
) -> Plan:
    """A plan from a step over the horizon with its first unit columns; the actuators move for a time h."""
    held, layout = prepared.held, prepared.held.step.layout
    scale, W_aa = (
        max(prepared.scales.tolist()),
        step.compliance.W[layout.actuators, layout.actuators],
    )
    if step.frictional:
        scale = min(scale, energy_cap(W_aa, robot.limits, robot.part_size))
    weight, held_to = settings.epsilon * scale, _held_back_to(prepared, aim)
    counted, target, back = weighed(aim, held_to, prepared.clusters, prepared.scales)
    kept = held.delta[layout.actuators]
    left, guess, cut = settings.enrichment.rounds, None, aim.cut
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
            problem = with_slip(problem, step, prepared.forces, float(aim.scale.max()), aim.looking)
        others = len(problem.G)
        problem = with_force_limits(problem, aim.grasp, step, held)
        if step.frictional and len(step.extra) > 0:
            forces, a = _forces_of_hold(prepared, step), places.actuators
            forces = forces if reduced is None else reduced.with_cables(effort, forces)
            given = settings.friction_share, robot.part_size, weight * W[a, a], settings.search
            contacts = PlanContacts.of(step, forces, *given)
            before = None if cut is None else cut.on(step, free, len(problem.m))
            search = PlanSearch(contacts, start.lam_a, guess, before)
            problem, solution = solve_relaxed(problem, others, search, EMPTY[:1] if elastic else ())
            guess, columns = solution if solution.status.usable else None, len(prepared.forces.beta)
            cut = None if search.cut is None else CutPlan.of(search.cut, step, free, columns)
        else:
            solve = partial(_without_friction, start, settings.qpcc)
            problem, solution = solve_relaxed(problem, others, solve, EMPTY if elastic else ())
        if reduced is not None:
            lam = reduced.forces(solution)
        else:
            lam = np.concatenate([np.zeros(layout.n_e), solution.lam_a, solution.beta])
        found = predict(step, settings.enrichment, lam, left > 0 and solution.status.usable)
        if isinstance(found, PredictedStep):
            ended = solution.status, solution.certificate, solution.conflict
            return Plan(found, *ended, problem, start, held_to, cut)
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


def brings_nearer(robot: Robot, aim: Aim, plan: Plan, apart: float) -> bool:
    """Whether a plan moves the effectors towards a target that they have not met.

    Args:
        robot: the size of its parts.
        aim: targets and weights of the effector rows.
        plan: the plan.
        apart: how far holding leaves the effectors from their target [m].
    """
    return (
        apart <= MET * robot.part_size
        or distance_left(aim, plan.predicted) < (1.0 - NEARER) * apart
    )


def distance_left(aim: Aim, predicted: PredictedStep) -> float:
    """How far a step leaves the effectors from their target, as they are weighted [m]."""
    rows = predicted.delta[predicted.step.layout.effectors]
    return _length(aim.scale * (rows - aim.target))


def _length(rows: Array) -> float:
    """Length of rows (n_e,), also of those whose squares overflow."""
    return math.hypot(*rows.tolist())


def _presses_as_it_may(prepared: Prepared, plan: Plan, grasp: Grasp | None) -> bool:
    """Whether the contact forces of a plan are at a limit of them."""
    if grasp is None:
        return False
    rows = grasp.rows(plan.predicted.step, prepared.held)
    return rows is not None and rows.reached(
        plan.predicted.lam[plan.predicted.step.layout.contacts]
    )


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
