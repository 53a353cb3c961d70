"""Plans of robots whose contacts have friction, and the search for contact.

Clusters that have no contact with friction are planned beside these, by a problem of their own: the search
asks whether any effort moves the effectors, and how near a plan brings them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.controller.friction import ALL_TRIED, MET, CutPlan, with_known_columns
from tauten.controller.planning.inverse import Aim
from tauten.controller.planning.locks import no_locks
from tauten.controller.planning.plan import (
    Plan,
    Prepared,
    Situation,
    distance_left,
    plan_from,
)
from tauten.controller.qpcc import Status
from tauten.model import Command, CondensedStep, Grasp, Robot, under_friction
from tauten.model.numerics import Bools

ENDLESSLY = 1e6  # s, in which every actuator can get everywhere
NEAREST = 40  # candidates in range that a search for contact looks at
NEARER = 1e-3  # of the distance of the effectors from their target, that a plan takes off it


def make_plan(situation: Situation, aim: Aim) -> Plan:
    """Pose and solve (T1) until no candidate in range is predicted deeper than the tolerance.

    Holding is always among what the position limits allow, so that a slack cable whose path has become
    shorter than its winch can follow stands in nobody's way. Where other limits leave nothing, those in
    conflict are relaxed as little as possible; the status is RELAXED then.

    Where contacts in range have friction, plans count on a share of it. Where such a plan brings effectors
    that are not at their target no nearer, another one with the nearest candidates in range and without rates
    looks for contact; where that finds none and a limit of contact forces is reached, the status is OK. Where
    forces within the cones are not found, the friction of the last step is a load. A search that was cut goes
    on where it was. Clusters without such contacts have a plan of their own, whose limits and targets are
    theirs; where both plans are usable, one is made of them.

    Args:
        situation: what the plan starts from and what bounds it.
        aim: targets of the effector rows.
    """
    prepared, h = situation.prepared, situation.robot.h
    if not prepared.farther.frictional:
        return plan_from(situation, aim, prepared.held.step, h)
    clusters = prepared.clusters
    if all(clusters.rubbing.tolist()):
        return _with_friction(situation, aim)
    one = _holding(situation, ~clusters.rubbing)
    other, others = _holding(situation, clusters.rubbing), aim.among(clusters, ~clusters.rubbing)
    if not _any_free(one):
        return plan_from(situation, replace(aim, grasp=others.grasp), _loaded(prepared), h)
    plan = _with_friction(one, aim.among(clusters, clusters.rubbing))
    if not (plan.status.usable and _any_free(other)):
        return plan
    beside = plan_from(other, others, _loaded(prepared), h)
    if not beside.status.usable:
        return replace(beside, cut=plan.cut)
    rows = clusters.rubbing[clusters.of_effectors], clusters.rubbing[clusters.of_actuators]
    return _joined(plan, beside, np.concatenate(rows))


def _with_friction(situation: Situation, aim: Aim) -> Plan:
    """A plan with the friction of contacts, and where it brings nothing nearer one that looks for contact."""
    robot, prepared, settings = situation.robot, situation.prepared, situation.settings
    resumed = aim.cut is not None and aim.cut.seeking
    first = replace(aim, cut=CutPlan(ALL_TRIED)) if resumed else aim
    step = with_known_columns(prepared.farther, prepared.held.step, aim.pushed)
    apart = distance_left(aim, prepared.held)
    plan = plan_from(situation, first, step, robot.h)
    met = plan.status is Status.SEEKING_CONTACT and apart <= MET * robot.part_size
    plan = replace(plan, status=Status.OK) if met else plan
    if plan.status is Status.NOT_FOUND:
        return plan_from(situation, first, _loaded(prepared), robot.h)
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
    search = replace(situation, settings=replace(settings, seeking=hidden))
    seeking = plan_from(search, aim, step, ENDLESSLY)
    cut = None if seeking.cut is None else replace(seeking.cut, seeking=True)
    if seeking.status.usable and brings_nearer(robot, aim, seeking, apart):
        relaxed = seeking.status is Status.RELAXED  # of the two, what a user must know
        return replace(
            seeking, status=Status.RELAXED if relaxed else Status.SEEKING_CONTACT, cut=cut
        )
    if hidden and _presses_as_it_may(prepared, plan, aim.grasp):
        return replace(plan, status=Status.OK, cut=cut)
    return replace(plan, cut=cut)


def _loaded(prepared: Prepared) -> CondensedStep:
    """The step over the horizon with the friction of the last step as a load."""
    loaded = prepared.held.step
    return under_friction(prepared.farther, prepared.forces) if loaded.frictional else loaded


def _holding(situation: Situation, kept: Bools) -> Situation:
    """The same where the actuators of some clusters (c,) keep their efforts, wherever that leads."""
    robot, prepared, locks = situation.robot, situation.prepared, situation.locks
    rows, limits = kept[prepared.clusters.of_actuators], robot.limits  # (n_a,)
    locks = no_locks(len(rows)) if locks is None else locks
    least = np.where(rows, -np.inf, limits.position_min)
    most = np.where(rows, np.inf, limits.position_max)
    free = replace(limits, position_min=least, position_max=most)
    forced = np.where(rows, prepared.held.effort, locks.effort)
    locks = Command(np.where(rows, np.nan, locks.position), forced)
    return replace(situation, robot=replace(robot, limits=free), locks=locks)


def _any_free(situation: Situation) -> bool:
    """Whether any actuator is decided."""
    locks = situation.locks
    return locks is None or not all((locks.by_position | locks.by_force).tolist())


def _joined(plan: Plan, beside: Plan, own: Bools) -> Plan:
    """One plan of two, whose clusters do not act on each other.

    Args:
        plan: of the clusters with friction; its contact forces are kept.
        beside: of the others.
        own: (n_e + n_a,) the rows of effectors and actuators of the first.
    """
    one, other, certificate = plan.predicted, beside.predicted, plan.certificate
    delta, lam, n = one.delta.copy(), one.lam.copy(), len(own)
    delta[:n] = np.where(own, one.delta[:n], other.delta[:n])
    lam[:n] = np.where(own, one.lam[:n], other.lam[:n])
    effort = np.where(own[one.step.layout.actuators], one.effort, other.effort)
    second = beside.certificate
    worse = replace(
        certificate,
        primal=max(certificate.primal, second.primal),
        complementarity=max(certificate.complementarity, second.complementarity),
        stationarity=max(certificate.stationarity, second.stationarity),
    )
    return replace(
        plan,
        predicted=replace(one, delta=delta, lam=lam, effort=effort),
        status=beside.status if plan.status is Status.OK else plan.status,
        certificate=worse,
        conflict=(*plan.conflict, *beside.conflict),
        held_to=np.where(own[: len(plan.held_to)], plan.held_to, beside.held_to),
    )


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


def _presses_as_it_may(prepared: Prepared, plan: Plan, grasp: Grasp | None) -> bool:
    """Whether the contact forces of a plan are at a limit of them."""
    if grasp is None:
        return False
    rows = grasp.rows(plan.predicted.step, prepared.held)
    return rows is not None and rows.reached(
        plan.predicted.lam[plan.predicted.step.layout.contacts]
    )
