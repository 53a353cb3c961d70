"""One control step, the page to read first: prepare, decide, advance.

`prepare` is all that does not need the target: the finite-element system, the rows, the compliance
between them. `decide` solves the small QPCC (T1) for the target that has just arrived. `advance` moves the
model. So the latency from target to tensions is that of `decide` alone, whatever the size of the mesh.

No decision is accepted before the gaps of all candidates in range are predicted: where one is deeper
than the tolerance, a unit column joins the contact basis for this step and the QPCC is solved again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.controller.inverse import energy_scale, exact_problem, inverse_problem, weighted_rows
from tauten.controller.locks import LockedStep
from tauten.controller.qpcc import (
    NO_PIECE,
    Certificate,
    Qpcc,
    QpccSettings,
    Start,
    Status,
    solve_qpcc,
)
from tauten.model import (
    Actuators,
    Command,
    Compliance,
    CondensedStep,
    ContactSpace,
    Enrichment,
    EnrichmentLoop,
    Forces,
    ForwardStep,
    Limits,
    PredictedStep,
    Robot,
    State,
    condense_step,
    forward_step,
    one_blas_thread,
)
from tauten.model.numerics import Array, Bools

EXACTLY = 1e-7  # of the robot's size, within which an exact effector meets its target
ROUNDING = 1e-6  # of the largest tension; what a solver's rounding may exceed it by


@dataclass(frozen=True, slots=True)
class Prepared:
    """All of a step but the target.

    Attributes:
        step: system, rows, compliance of effectors, cables, reduced contacts and unit columns.
        forces: of the last step, where the solvers start.
        scale: of the actuation energy, s in (T1) [m/N].
    """

    step: CondensedStep
    forces: Forces
    scale: float


@dataclass(frozen=True, slots=True)
class DecideSettings:
    """Weights and tolerances of `decide`.

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
    """The result of `decide` or `hold`.

    Attributes:
        predicted: forces, motion, and the step with the unit columns that joined.
        status: how the solver ended.
        certificate: of the solution, with the gaps of all candidates in range.
        conflict: names of the limits that conflict.
        problem: the QPCC that was solved last; None for a hold.
        start: where its solver started; None for a hold.
    """

    predicted: PredictedStep
    status: Status
    certificate: Certificate
    conflict: tuple[str, ...] = ()
    problem: Qpcc | None = None
    start: Start | None = None


@one_blas_thread()
def prepare(
    robot: Robot, space: ContactSpace, state: State, forces: Forces, enrichment: Enrichment
) -> Prepared:
    """Linearise, detect contacts, condense: all of a step that needs no target.

    Args:
        robot: its factorisation workspace is in use until the next `prepare`.
        space: basis of the contact forces.
        state: where the step starts.
        forces: of the last step. Its tensions add to the tangent, unit columns that pushed are kept,
            contacts that pushed set the scale of the actuation energy.
        enrichment: whether gaps are checked at all.

    Raises:
        FactorisationError: the state has diverged.
    """
    contacts = space.k > 0 or enrichment.rounds > 0
    step = condense_step(robot, space, state, forces, contacts, effectors=True)
    pushing, groups = step.pushing(forces), robot.actuators.groups
    W, _ = weighted_rows(step.compliance.W, step.compliance.delta_free, robot.effector_layout)
    scale = energy_scale(W, step.n_e, step.n_a, pushing, groups)
    return Prepared(step, forces, scale)


@one_blas_thread()
def decide(
    robot: Robot,
    prepared: Prepared,
    goal: Array,
    pull: Array,
    settings: DecideSettings,
    locks: Command | None = None,
) -> Decision:
    """Find the tensions that bring the effectors to a goal within one step.

    As near as possible, weighed against the energy of the actuators; rows of exact effectors are
    equations, met within 1e-7 of the robot's size. Where no efforts meet these, the nearest is decided as
    without them, with the status NOT_EXACT and the names of the rows that are missed and of limits in
    conflict with them.

    Args:
        robot: limits, time step, kinds and weights of the effectors.
        prepared: the step.
        goal: (n_v,) values of the effectors, see `EffectorLayout`.
        pull: (n_a,) positions of the actuators commanded last [m].
        settings: weights and tolerances.
        locks: what locked actuators keep in this step; None: all are decided.
    """
    layout = robot.effector_layout
    target = layout.row_targets(prepared.step.rows.effectors.values, goal)  # (n_e,)
    if not layout.any_exact:
        return _decide(robot, prepared, target, pull, settings, locks)
    decision = _decide(robot, prepared, target, pull, settings, locks, exact=True)
    if decision.status.usable:
        return decision
    nearest = _decide(robot, prepared, target, pull, settings, locks)
    if not nearest.status.usable:
        return nearest
    missed = layout.missed_rows(target - nearest.predicted.delta[: layout.n_rows])
    limits = (name for name in decision.conflict if name not in (*missed, *NO_PIECE))
    return replace(nearest, status=Status.NOT_EXACT, conflict=(*missed, *limits))


def _decide(
    robot: Robot,
    prepared: Prepared,
    target: Array,
    pull: Array,
    settings: DecideSettings,
    locks: Command | None,
    exact: bool = False,
) -> Decision:
    """`decide` for row targets (n_e,), with or without equations for the rows of exact effectors."""
    layout = robot.effector_layout
    target = target if layout.unweighted else layout.scale * target
    weight = settings.epsilon * prepared.scale
    loop = EnrichmentLoop(prepared.step, settings.enrichment)
    while loop.prediction is None:
        reduced = None if locks is None else LockedStep(loop.step, locks)
        if reduced is None:
            rows: LockedStep | Compliance = loop.step.compliance
            limits, actuators, travelled = robot.limits, robot.actuators, pull
            start = Start(prepared.forces.tension, loop.step.pushing(prepared.forces))
        else:
            rows, free = reduced, reduced.free
            limits, actuators, travelled = (
                robot.limits.at(free),
                robot.actuators.at(free),
                pull[free],
            )
            start = reduced.start(loop.step, prepared.forces)
        W, delta_free = weighted_rows(rows.W, rows.delta_free, layout)
        problem = inverse_problem(
            W, delta_free, target, travelled, limits, robot.h, weight, actuators
        )
        if reduced is not None:
            problem = reduced.bounded(problem, robot.limits, robot.actuators)
        if exact:
            problem = exact_problem(problem, W, delta_free, target, layout, EXACTLY * robot.size)
        solution = solve_qpcc(problem, start, settings.qpcc)
        if reduced is not None:
            lam = reduced.forces(solution)
        else:
            lam = np.concatenate([np.zeros(robot.n_e), solution.lam_a, solution.beta])
        loop.check(lam, solution.status.usable)
    residuals = solution.certificate
    certificate = Certificate(
        residuals.primal,
        residuals.complementarity,
        residuals.stationarity,
        loop.prediction.deepest_gap,
        len(loop.prediction.step.extra),
    )
    return Decision(
        loop.prediction, solution.status, certificate, solution.conflict, problem, start
    )


@one_blas_thread()
def advance(robot: Robot, predicted: PredictedStep) -> State:
    """The model's state after the step."""
    return robot.advance(predicted.step.state, predicted.step.system, predicted.dv)


@one_blas_thread()
def hold(robot: Robot, prepared: Prepared, command: Command, enrichment: Enrichment) -> Decision:
    """The step of a robot whose actuators keep what is given of them.

    A cable that is held may be slack but not longer: 0 ≤ δ_a − pull ⟂ λ_a ≥ 0, an LCP with the contacts.
    Its tension follows from the robot and may exceed the cable's limit: the status is then INFEASIBLE and
    `conflict` names the cables, as it names "complementarity" where no forces solve the LCP. The same holds
    for the efforts of other actuators that keep their position.

    Args:
        robot: limits.
        prepared: the step.
        command: position or effort that each actuator keeps.
        enrichment: when unit columns are added.
    """
    solved = forward_step(prepared.step, enrichment, prepared.forces, command)
    step, lam, actuators = solved.prediction.step, solved.prediction.lam, robot.actuators
    excess = beyond(lam[step.n_e : step.n_e + step.n_a], robot.limits, actuators.bilateral)
    names = actuators.effort_names
    conflict = tuple(names[i] for i in np.flatnonzero(excess > ROUNDING).tolist())
    if not solved.converged:
        conflict = (*conflict, "complementarity")
    status = Status.INFEASIBLE if conflict else Status.OK
    certificate = hold_certificate(solved, command, robot.limits, actuators)
    return Decision(solved.prediction, status, certificate, conflict)


def beyond(effort: Array, limits: Limits, bilateral: Bools) -> Array:
    """How far efforts (n_a,) exceed their limits, relative to the largest magnitude: (n_a,), negative within.

    The least tension of a cable does not count: one that is held may be slack.

    Args:
        effort: (n_a,) [N, Pa].
        limits: of the actuators.
        bilateral: (n_a,) which actuators pull and push.
    """
    below = np.where(bilateral, limits.tension_min - effort, -np.inf)
    excess: Array = np.maximum(effort - limits.tension_max, below) / limits.largest_tension
    return excess


def hold_certificate(
    solved: ForwardStep, command: Command, limits: Limits, actuators: Actuators
) -> Certificate:
    """Residuals of a hold, relative to the row values and to the largest efforts.

    An LCP is the optimality condition of min ½ λᵀ W λ + δ_freeᵀ λ over λ ≥ 0: the gradient is δ, and the
    norm of min(w_ii λ_i, δ_i) is that of the projected gradient. That of a bilateral actuator is δ_i alone.

    Args:
        solved: forces and motion.
        command: position or effort that each actuator keeps.
        limits: of the actuators.
        actuators: which of them are bilateral; rows in the same unit have one scale.
    """
    step, lam = solved.prediction.step, solved.prediction.lam[solved.prediction.step.n_e :]
    W = step.compliance.W[step.n_e :, step.n_e :]
    n_a, by_force = step.n_a, command.by_force
    delta_free = step.compliance.delta_free[step.n_e :].copy()
    delta_free[:n_a] -= np.where(by_force, 0.0, command.pull)
    delta, force = delta_free + W @ lam, np.diag(W) * lam  # (m,) m
    groups = np.concatenate([actuators.position_groups, np.zeros(len(lam) - n_a, np.int64)])
    size = np.maximum(np.abs(delta_free), np.abs(force))
    scale = np.array([size[groups == groups[i]].max() for i in range(len(size))])  # (m,)
    scale = np.where(scale > 0.0, scale, 1.0)
    kept = np.concatenate([~by_force, np.ones(len(lam) - n_a, np.bool_)])
    zero = np.concatenate([actuators.bilateral, np.zeros(len(lam) - n_a, np.bool_)])
    residual = np.where(zero, delta, np.minimum(force, delta))[kept] / scale[kept]
    violation = (np.where(zero, np.abs(delta), -delta) / scale)[kept]
    excess = beyond(lam[:n_a], limits, actuators.bilateral)
    return Certificate(
        primal=max(0.0, float(violation.max(initial=0.0)), float(excess.max(initial=0.0))),
        complementarity=float(np.abs(residual).max(initial=0.0)),
        stationarity=float(np.linalg.norm(residual)),
        deepest_gap=solved.prediction.deepest_gap,
        extra_columns=len(step.extra),
    )
