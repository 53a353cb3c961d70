"""The plan of a decision: the QPCC (T1) over the horizon, posed, solved and checked.

The plan is an implicit step as long as the horizon from the present state. It ends where the robot comes to
rest, but for the inertia that a horizon leaves: so a plan weighs directions by stiffness and not by inertia,
and neither chases a target out of reach nor excites vibrations. The positions that it may ask for are those
that the actuators reach within one tick; a step of that size is what the linearisation is good for.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from tauten.controller.friction import CutPlan, PlanSearch, pushed_slots
from tauten.controller.planning.inverse import Aim
from tauten.controller.planning.posing import Posed, pose, weights_of
from tauten.controller.planning.prepared import Prepared, Situation
from tauten.controller.qpcc import (
    Certificate,
    Qpcc,
    QpccSettings,
    Solution,
    Solve,
    Start,
    Status,
    solve_qpcc,
    solve_relaxed,
)
from tauten.model import CondensedStep, PredictedStep, predict, unit_start
from tauten.model.numerics import Array, Ints

EMPTY = (Status.INFEASIBLE, Status.NOT_FOUND)  # of a QPCC whose limits are relaxed


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


def plan_from(situation: Situation, aim: Aim, step: CondensedStep, h: float) -> Plan:
    """A plan from a step over the horizon with its first unit columns.

    Args:
        situation: what it starts from and what bounds it.
        aim: targets of the effector rows.
        step: over the horizon.
        h: time for which the actuators move [s].
    """
    settings, weights = situation.settings, weights_of(situation, aim, step)
    elastic: tuple[Status, ...] = () if any(aim.equations.tolist()) else EMPTY
    left, guess, before = settings.enrichment.rounds, None, aim.cut
    while True:
        posed, cut = pose(situation, aim, weights, step, h), None
        solve: PlanSearch | Solve = partial(_without_friction, posed.start, settings.qpcc)
        relaxed = elastic
        if step.frictional and len(step.extra) > 0:
            solve = _search(situation, posed, weights.energy, guess, before)
            relaxed = elastic[:1]
        problem = posed.problem
        solution = solve(problem, None)
        if solution.status in relaxed:
            problem, solution = solve_relaxed(problem, solution, posed.others, solve, relaxed)
        if isinstance(solve, PlanSearch):
            guess = solution if solution.status.usable else None
            if solve.cut is not None:
                columns = len(situation.prepared.forces.beta)
                cut = CutPlan.of(solve.cut, step, posed.free, columns)
            before = cut
        lam, more = posed.forces(solution), left > 0 and solution.status.usable
        found = predict(step, settings.enrichment, lam, more)
        if isinstance(found, PredictedStep):
            return Plan(
                predicted=found,
                status=solution.status,
                certificate=solution.certificate,
                conflict=solution.conflict,
                problem=problem,
                start=posed.start,
                held_to=weights.held_to,
                cuts=(cut,),
                pushed=pushed_slots(found),
            )
        step, left = found, left - 1


def _search(
    situation: Situation,
    posed: Posed,
    energy: float,
    guess: Solution | None,
    cut: CutPlan | None,
) -> PlanSearch:
    """The search of a plan with friction.

    Args:
        situation: what the plan starts from.
        posed: the problem.
        energy: weight of the energy of the actuators, ε s [m/N].
        guess: answer before the last contacts joined; None: there is none.
        cut: where the last search was cut; None: it was not.
    """
    prepared, settings, step = situation.prepared, situation.settings, posed.step
    forces, actuators = _forces_of_hold(prepared, step), posed.layout.actuators
    if posed.unlocked is not None:
        held = prepared.held
        forces = posed.unlocked.with_cables(held.lam[held.step.layout.actuators], forces)
    return PlanSearch(
        friction=settings.friction_share * step.friction,
        lam=posed.start.lam_a,
        forces=forces,
        size=situation.robot.part_size,
        energy=energy * posed.W[actuators, actuators],
        settings=settings.search,
        guess=guess,
        cut=None if cut is None else cut.on(step, posed.free, len(posed.problem.m)),
    )


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


def _without_friction(
    start: Start, settings: QpccSettings, problem: Qpcc, near: Solution | None
) -> Solution:
    """Solve a QPCC from its start, or from the nearest point to the limits."""
    begin = start if near is None else Start(near.lam_a, near.piece)
    return solve_qpcc(problem, begin, settings)
