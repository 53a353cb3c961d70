"""One control step, the page to read first: prepare, decide, advance.

`prepare` is all that does not need the target: the finite-element system, the rows, the compliance
between them. `decide` solves the small QPCC (T1) for the target that has just arrived. `advance` moves the
model. So the latency from target to tensions is that of `decide` alone, whatever the size of the mesh.

A decision looks as far ahead as the horizon: (T1) is posed on an implicit step of that length. What leaves
is the first tick on the way there, within the limits of position, rate and effort, and the model advances by
that tick.

No decision is accepted before the gaps of all candidates in range are predicted: where one is deeper
than the tolerance, a unit column joins the contact basis for this step and the QPCC is solved again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.controller.actuation import Actuation, values_known
from tauten.controller.carried import (
    Carried,
    change_of,
    nothing_carried,
    objective_of,
    sight_after,
)
from tauten.controller.certificates import hold_certificate
from tauten.controller.damping import Dampings
from tauten.controller.planning import (
    Aim,
    DecideSettings,
    Horizon,
    Plan,
    Prepared,
    Situation,
    ahead_of_locks,
    held_taut,
    make_plan,
    missed_rows,
    prepared_plans,
    step_ahead,
    with_exact_rows,
)
from tauten.controller.qpcc import Certificate, Qpcc, Start, Status
from tauten.controller.winches import (
    exceeded,
    first_tick,
    given_in,
    jammed,
    reach_held,
    reach_of,
    stalled_locks,
    take_tick,
)
from tauten.model import (
    Command,
    ContactSpace,
    Enrichment,
    Forces,
    PredictedStep,
    Robot,
    State,
    condensed,
    gains_energy,
    moves_far,
    one_blas_thread,
    travel,
)
from tauten.model.numerics import Array, Bools, FactorisationError

FARTHEST = 0.25  # of the size of the largest part, in a tick; a model that is faster has diverged
# What is not finite is looked for in results, which have a status for it: numpy does not warn of it before.
_quiet = np.errstate(over="ignore", invalid="ignore")


@dataclass(frozen=True, slots=True)
class Decision:
    """The result of `decide` or `hold`.

    Attributes:
        predicted: forces and motion in the tick, and its step with the unit columns that joined; of a
            decision that is not usable, over the horizon.
        position: (n_a,) positions of the actuators after it, within their limits and rates.
        status: how it ended.
        certificate: of the QPCC, or of the hold, with the gaps of all candidates in range after the tick.
        conflict: names of the limits that conflict.
        stalled: (n_a,) which locks have stopped because more would exceed a limit.
        plan: over the horizon; None for a hold.
        carried: what the next decision takes over; None for a hold.
        goal: (n_v,) that was decided for; None for a hold, and where the decision is not usable.
        command: position or effort that each actuator has at the end of the tick; None where the decision is
            not usable.
    """

    predicted: PredictedStep
    position: Array
    status: Status
    certificate: Certificate
    conflict: tuple[str, ...]
    stalled: Bools
    plan: Plan | None = None
    carried: Carried | None = None
    goal: Array | None = None
    command: Command | None = None

    @property
    def problem(self) -> Qpcc | None:
        """The QPCC that was solved last; None for a hold."""
        return None if self.plan is None else self.plan.problem

    @property
    def start(self) -> Start | None:
        """Where its solver started; None for a hold."""
        return None if self.plan is None else self.plan.start


@one_blas_thread(whole=True)
@_quiet
def prepare(
    horizon: Horizon,
    space: ContactSpace,
    state: State,
    forces: Forces,
    position: Array,
    enrichment: Enrichment,
    course: Array | None = None,
    forced: Bools | None = None,
) -> Prepared:
    """Linearise, detect contacts, condense: all of a step that needs no target but those before.

    Args:
        horizon: the robot; its factorisation workspaces are in use until the next `prepare`.
        space: basis of the contact forces.
        state: where the step starts.
        forces: of the last step. Its tensions add to the tangent, unit columns that pushed are kept.
        position: (n_a,) positions of the actuators commanded last [m].
        enrichment: whether gaps are checked at all.
        course: (s, n_v) goals of the last ticks, see `with_goal`; None: there were none.
        forced: (n_a,) actuators that are locked at an effort; None: none is.

    Raises:
        FactorisationError: the state has diverged, or an obstacle's shape gives no distance.
    """
    robot = horizon.robot
    contacts = space.k > 0 or enrichment.rounds > 0
    assembled = robot.body.assemble(state, forces.effort)
    system = robot.body.system(assembled, robot.integration)
    step = condensed(robot, space, state, forces, system, contacts, effectors=True)
    if not np.logical_and.reduce(np.isfinite(step.rows.contacts.rows.delta)):
        raise FactorisationError("the distance of a contact is not known")
    here, yielding = position.copy(), robot.actuators.laws.held_by_force
    here[yielding] = step.rows.actuators.delta[yielding]
    keep = Command.of(here, None)
    taut, least = held_taut(horizon, step, forces.effort)
    if forced is not None:
        taut &= ~forced
    while True:
        farther = step_ahead(horizon, space, assembled, step, forces, course, taut)
        prepared = prepared_plans(horizon, step, farther, forces, keep, enrichment)
        slack = taut & ~robot.actuators.laws.bilateral & (prepared.held.effort < -least)
        if farther.rho is None or not any(slack.tolist()):
            return prepared
        taut &= ~slack  # cables that hang slack at the end have no stiffness


@one_blas_thread(whole=True)
@_quiet
def decide(
    robot: Robot,
    prepared: Prepared,
    goal: Array,
    position: Array,
    settings: DecideSettings,
    locks: Command | None = None,
    carried: Carried | None = None,
) -> Decision:
    """Find the tensions that bring the effectors to a goal.

    As near as possible, weighed against the energy of the actuators; rows of exact effectors are
    equations, met within 1e-7 of the size of the largest part at the end of the horizon. Where no efforts
    meet these, their distance is made as small as possible and the others follow from what remains, with the
    status NOT_EXACT and the names of the rows that are missed and of limits in conflict with them.

    Args:
        robot: limits, time step, kinds and weights of the effectors.
        prepared: the step.
        goal: (n_v,) values of the effectors, see `EffectorLayout`.
        position: (n_a,) positions of the actuators commanded last [m].
        settings: weights and tolerances.
        locks: what locked actuators keep in this step; None: all are decided.
        carried: from the decisions before; None: nothing.
    """
    layout, clusters, size = robot.effector_layout, prepared.clusters, robot.part_size
    carried = carried or nothing_carried(settings.forces)
    before = carried.dampings or Dampings.at_start(clusters)
    dampings = before.towards(goal, size, robot.h, layout, robot.contacts.frictional)
    values = prepared.farther.rows.effectors.values
    target = layout.row_targets(values, goal)  # (n_e,)
    aim = Aim(
        target=target,
        scale=layout.scale,
        equations=layout.exact,
        gamma=dampings.gamma,
        grasp=carried.grasp,
        pushed=carried.pushed,
        looking=carried.sight > 0.0,
    )
    kept = None if locks is None else ahead_of_locks(locks, position)
    situation = Situation(robot, prepared, position, settings, kept)
    plan = make_plan(situation, aim, carried.cuts)
    if layout.any_exact:
        plan = with_exact_rows(situation, aim, plan)
    finite = layout.positions_only or values_known(prepared.step.rows.effectors)
    status = plan.status if finite else Status.NOT_FINITE
    if not status.usable:
        return Decision(
            predicted=plan.predicted,
            position=position,
            status=status,
            certificate=plan.certificate,
            conflict=plan.conflict,
            stalled=np.zeros(robot.n_a, np.bool_),
            plan=plan,
            carried=carried.without_plan(dampings, plan.cuts),
        )

    weights = settings.epsilon * prepared.scales  # (c,)
    change = change_of(prepared, plan, aim, weights[clusters.of_actuators])
    dampings = dampings.fading(change, size, robot.h)
    sight = 0.0
    if robot.contacts.loose and robot.contacts.frictional:
        sight = sight_after(robot, prepared, plan, aim, carried.sight)
    forces, apart = prepared.forces, clusters if sight > 0.0 else None
    planned = Command(plan.predicted.delta[robot.layout.actuators], plan.predicted.effort)
    wanted, reach = first_tick(
        robot, planned, position, locks, forces.effort, dampings.share, apart
    )
    tick = take_tick(prepared.step, settings.enrichment, forces, wanted, reach, robot.limits)
    after, names = tick.solved, exceeded(robot, tick)
    conflict = tuple(dict.fromkeys((*plan.conflict, *names)))
    certificate = Certificate(
        primal=plan.certificate.primal,
        complementarity=plan.certificate.complementarity,
        stationarity=plan.certificate.stationarity,
        deepest_gap=after.deepest_gap,
        extra_columns=len(after.step.extra),
    )
    if jammed(robot, tick):
        return Decision(
            predicted=after,
            position=tick.position,
            status=Status.INFEASIBLE,
            certificate=certificate,
            conflict=conflict,
            stalled=np.zeros(robot.n_a, np.bool_),
            plan=plan,
            carried=carried.without_plan(dampings, plan.cuts),
        )

    last = dampings.compared(before.goal)
    reached = target if last is goal else layout.row_targets(values, last)  # (n_e,)
    moved = tick.position - position, after.effort
    objectives = []
    for own, one, weight in zip(clusters.each, dampings.each, weights.tolist(), strict=True):
        known = one.objective
        found = objective_of(prepared, plan, aim, weight, moved, reached, known, own)
        objectives.append(found)
    conflicting = plan.conflict and plan.status is not Status.NOT_EXACT
    stalled, supplied = np.zeros(robot.n_a, np.bool_), robot.actuators.laws.held_by_force
    if locks is not None:
        stalled, supplied = stalled_locks(locks, tick, robot), supplied & ~locks.by_position
    return Decision(
        predicted=after,
        position=tick.position,
        status=Status.RELAXED if names or conflicting else status,
        certificate=certificate,
        conflict=conflict,
        stalled=stalled,
        plan=plan,
        carried=Carried(
            dampings=dampings.adapted(change, size, robot.h, objectives),
            grasp=carried.grasp,
            cuts=plan.cuts,
            pushed=plan.pushed,
            sight=sight,
        ),
        goal=goal,
        command=given_in(tick, supplied, robot.limits),
    )


@one_blas_thread(whole=True)
@_quiet
def advance(
    robot: Robot,
    space: ContactSpace,
    settings: DecideSettings,
    decision: Decision,
    before: Actuation,
    now: Actuation,
) -> tuple[State, Forces, PredictedStep]:
    """The state after the tick, in which the actuators move evenly to what left; its last step, with forces.

    The decision predicts the tick with one linearisation; the model follows what left in steps of second
    order (`tauten.model.simulation.travel`). Without sub-steps it moves as the decision predicts, unless a
    quasi-static one moves far in it, or another one gains energy. So it does where these steps diverge or
    their matrix has no factor: their linearisation is where the velocity leads, which may be far beyond.

    Raises:
        FactorisationError: the state has diverged.
    """
    given, predicted = decision.command, decision.predicted
    step, forces = predicted.step, predicted.step.split(predicted.lam, space.k)
    if settings.substeps > 0 or moves_far(robot, predicted) or gains_energy(robot, predicted):
        if given is None:
            command = Command.of(now.position, None)
        else:
            command = Command.either(np.isnan(given.position), now.position, given.effort)
        start = Command(before.position, before.effort)
        h, substeps = step.system.h, settings.substeps or 1
        try:
            moved = travel(
                robot, space, settings.enrichment, step.state, forces, start, command, substeps
            )
            way = robot.body.displacement(moved.state, h * moved.state.v)  # of the next tick [m]
        except FactorisationError:
            way = np.inf
        if way < FARTHEST * robot.part_size:  # not where it is NaN
            return moved.state, moved.forces, moved.last
    end = robot.body.advance(step.state, step.system.v + predicted.dv, step.system.h)
    return end, forces, predicted


@one_blas_thread(whole=True)
@_quiet
def hold(
    robot: Robot,
    prepared: Prepared,
    command: Command,
    position: Array,
    enrichment: Enrichment,
    goal: Array | None = None,
) -> Decision:
    """The step of a robot whose actuators keep what is given of them.

    A cable that is held may be slack but not longer: 0 ≤ δ_a − pull ⟂ λ_a ≥ 0, an LCP with the contacts.
    Its tension follows from the robot and may exceed the cable's limit: the status is then INFEASIBLE and
    `conflict` names the cables, as it names "complementarity" where no forces solve the LCP. The same holds
    for the efforts of other actuators that keep their position. An actuator that moves towards a lock stops
    where it would exceed a limit.

    Args:
        robot: limits.
        prepared: the step.
        command: position or effort that each actuator keeps, or moves to in this step.
        position: (n_a,) positions of the actuators commanded last [m].
        enrichment: when unit columns are added.
        goal: (n_v,) values of the effectors that were asked for: the status is NOT_EXACT where exact ones
            miss theirs; None: none were.
    """
    reach = reach_of(position, robot.limits, robot.h)
    reach = reach_held(reach, position, command, prepared.forces.effort, robot.limits)
    tick = take_tick(prepared.step, enrichment, prepared.forces, command, reach, robot.limits)
    conflict = exceeded(robot, tick)
    layout, effectors = robot.effector_layout, prepared.step.rows.effectors
    status = Status.INFEASIBLE if conflict else Status.OK
    if not (conflict or layout.positions_only or values_known(effectors)):
        status = Status.NOT_FINITE
    if goal is not None and layout.any_exact and not conflict:
        target = layout.row_targets(effectors.values, goal)
        conflict = missed_rows(robot, tick.solved, target, layout.exact)
        status = Status.NOT_EXACT if conflict else status
    certificate = hold_certificate(tick.solved, tick.command, robot.limits, robot.actuators)
    stalled = stalled_locks(command, tick, robot)
    return Decision(
        predicted=tick.solved,
        position=tick.position,
        status=status,
        certificate=certificate,
        conflict=conflict,
        stalled=stalled,
        command=tick.command,
    )
