"""One control step, the page to read first: prepare, decide, advance.

`prepare` is all that does not need the target: the finite-element system, the rows, the compliance
between them. `decide` solves the small QPCC (T1) for the target that has just arrived. `advance` moves the
model. So the latency from target to tensions is that of `decide` alone, whatever the size of the mesh.

No decision is believed before the gaps of all candidates in range are predicted: where one is deeper
than the tolerance, a unit column joins the contact basis for this step and the QPCC is solved again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tauten.controller.compliance import Response
from tauten.controller.inverse import inverse_problem
from tauten.controller.qpcc import Certificate, QpccSettings, Solution, Start, Status, solve_qpcc
from tauten.model import (
    Compliance,
    ContactSpace,
    Enrichment,
    Forces,
    ReducedContacts,
    Robot,
    RobotRows,
    State,
    System,
    extended,
    row_compliance,
    unit_rows,
    worst_rows,
)
from tauten.model.numerics import Array, Bools, Ints, solve_lcp


@dataclass(frozen=True, slots=True)
class Prepared:
    """Everything about a step but the target.

    Attributes:
        state: where the step starts.
        system: factorised A, v_free.
        rows: effectors, actuators, contacts in range.
        reduced: contacts seen through the basis.
        extra: (r,) rows of `rows.contacts` that have a unit column.
        response: compliance of effectors, actuators, reduced contacts, unit columns, in this order.
    """

    state: State
    system: System
    rows: RobotRows
    reduced: ReducedContacts
    extra: Ints
    response: Compliance


@dataclass(frozen=True, slots=True)
class DecideSettings:
    """How `decide` weighs and checks.

    Attributes:
        epsilon: weight of the actuation energy in (T1), unitless.
        enrichment: when unit columns join the basis.
        qpcc: settings of the solver.
    """

    epsilon: float
    enrichment: Enrichment
    qpcc: QpccSettings


@dataclass(frozen=True, slots=True)
class Decision:
    """The answer to a target.

    Attributes:
        prepared: the step with the unit columns that joined.
        solution: tensions, contact forces, status.
        certificate: of the solution, with the gaps of all candidates in range.
        lam: (m,) forces on all rows of `prepared.response`, zero on the effectors.
        delta: (m,) predicted row values [m].
        dv: (n,) velocity change [m/s].
    """

    prepared: Prepared
    solution: Solution
    certificate: Certificate
    lam: Array
    delta: Array
    dv: Array


def prepare(
    robot: Robot, space: ContactSpace, state: State, forces: Forces, enrichment: Enrichment
) -> Prepared:
    """Linearise, detect, condense: all of a step that needs no target.

    Args:
        robot: whose factorisation workspace is used until the next `prepare`.
        space: basis of the contact forces.
        state: where the step starts.
        forces: those of the last step; its tensions curve the tangent, its unit columns stay.
        enrichment: whether gaps will be checked at all.

    Raises:
        FactorisationError: the state has blown up.
    """
    system = robot.linearise(state, forces.tension)
    rows = robot.rows(state, contacts=space.k > 0 or enrichment.rounds > 0)
    reduced = space.reduce(rows.contacts)
    extra = rows.contacts.rows_of(forces.pushed)
    H_extra, delta_extra = unit_rows(rows.contacts, extra)
    H = np.vstack([rows.effectors.dense(), rows.actuators.dense(), reduced.H, H_extra])
    delta = np.concatenate([rows.effectors.delta, rows.actuators.delta, reduced.delta, delta_extra])
    return Prepared(state, system, rows, reduced, extra, row_compliance(system, H, delta))


def decide(
    robot: Robot,
    prepared: Prepared,
    target: Array,
    pull: Array,
    forces: Forces,
    settings: DecideSettings,
) -> Decision:
    """Find the tensions that bring the effectors to a target within one step.

    Args:
        robot: limits and time step.
        prepared: the step.
        target: (n_e,) positions [m].
        pull: (n_a,) pulled lengths commanded last [m].
        forces: those of the last step, where the active set starts.
        settings: weights and tolerances.
    """

    def solve(prepared: Prepared) -> Solution:
        rows = prepared.response
        sizes = robot.n_e, robot.n_a, len(rows) - robot.n_e - robot.n_a
        response = Response(rows.W, rows.delta_free, *sizes)
        start = Start(forces.tension, warm_piece(prepared, forces))
        problem = inverse_problem(
            response, target, robot.limits, pull, robot.h, settings.epsilon, start.piece
        )
        return solve_qpcc(problem, start, settings.qpcc)

    return certified(robot, prepared, settings.enrichment, solve)


def hold(robot: Robot, prepared: Prepared, pull: Array, enrichment: Enrichment) -> Decision:
    """What the robot does while its winches stand still at pulled lengths (n_a,) [m].

    A cable that is held may be slack but not longer: 0 ≤ δ_a − pull ⟂ λ_a ≥ 0, an LCP with the contacts.
    """
    n_e, n_a = robot.n_e, robot.n_a

    def solve(prepared: Prepared) -> Solution:
        W = prepared.response.W[n_e:, n_e:]
        delta = prepared.response.delta_free[n_e:].copy()
        delta[:n_a] -= pull
        result = solve_lcp(W, delta)
        beta = result.lam[n_a:]
        judged = Certificate(0.0, result.residual, 0.0, np.inf)
        status = Status.OK if result.converged else Status.FEASIBLE_ONLY
        return Solution(result.lam[:n_a], beta, status, judged, 0.0, result.iterations, beta > 0.0)

    return certified(robot, prepared, enrichment, solve)


def advance(robot: Robot, decision: Decision) -> State:
    """The model's state after the step."""
    prepared = decision.prepared
    return robot.advance(prepared.state, prepared.system, decision.dv)


def certified(
    robot: Robot,
    prepared: Prepared,
    enrichment: Enrichment,
    solve: Callable[[Prepared], Solution],
) -> Decision:
    """Solve, predict the gaps of all candidates in range, add unit columns and repeat where needed."""
    contacts = prepared.rows.contacts
    for round_ in range(enrichment.rounds + 1):
        solution = solve(prepared)
        lam = np.concatenate([np.zeros(robot.n_e), solution.lam_a, solution.beta])
        dv = prepared.response.velocity_change(prepared.system, lam)
        gaps = predicted_gaps(prepared, dv)
        worst = worst_rows(contacts, gaps, enrichment, contacts.slots[prepared.extra])
        if len(worst) == 0 or round_ == enrichment.rounds or not solution.status.usable:
            break
        response = extended(prepared.system, prepared.response, *unit_rows(contacts, worst))
        extra = np.concatenate([prepared.extra, worst])
        prepared = replace(prepared, response=response, extra=extra)
    judged = solution.certificate
    certificate = Certificate(
        judged.primal,
        judged.complementarity,
        judged.stationarity,
        deepest_gap=float(gaps.min(initial=np.inf)),
        extra_columns=len(prepared.extra),
    )
    return Decision(
        prepared=prepared,
        solution=solution,
        certificate=certificate,
        lam=lam,
        delta=prepared.response.delta_free + prepared.response.W @ lam,
        dv=dv,
    )


def warm_piece(prepared: Prepared, forces: Forces) -> Bools:
    """Which columns in play pushed in the last step: (k' + r,) bool."""
    known = forces.beta[prepared.reduced.modes] > 0.0
    if len(prepared.extra) == 0:
        return known
    slots = prepared.rows.contacts.slots[prepared.extra]
    return np.concatenate([known, np.isin(slots, forces.pushed)])


def predicted_gaps(prepared: Prepared, dv: Array) -> Array:
    """Gaps of all candidates in range after a velocity change dv (n,): (m,) [m]."""
    system = prepared.system
    return prepared.rows.contacts.rows.after(system.h, system.v + dv)


def forces_of(robot: Robot, space: ContactSpace, decision: Decision) -> Forces:
    """The decision's forces by cable, mode and slot, to start the next step from."""
    prepared, n_e, n_a = decision.prepared, robot.n_e, robot.n_a
    k = n_e + n_a + len(prepared.reduced)
    beta = np.zeros(space.k)
    beta[prepared.reduced.modes] = decision.lam[n_e + n_a : k]
    slots = prepared.rows.contacts.slots[prepared.extra]
    return Forces(decision.lam[n_e : n_e + n_a], beta, slots, decision.lam[k:])
