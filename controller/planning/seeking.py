"""Plans of robots whose contacts have friction, and the search for contact.

Each cluster that has such contacts is planned by a problem of its own, and those without by another one: the
search asks whether any effort moves the effectors, and how near a plan brings them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.controller.friction import ALL_TRIED, MET, CutPlan, with_known_columns
from tauten.controller.planning.inverse import Aim
from tauten.controller.planning.locks import no_locks
from tauten.controller.planning.plan import Plan, plan_from
from tauten.controller.planning.posing import distance_left
from tauten.controller.planning.prepared import Prepared, Situation
from tauten.controller.qpcc import Status
from tauten.model import Clusters, Command, CondensedStep, Grasp, Robot, under_friction
from tauten.model.numerics import Bools

ENDLESSLY = 1e6  # s, in which every actuator can get everywhere
NEAREST = 40  # candidates in range that a search for contact looks at
FAR = 1e-2  # of the size of the largest part, from where objects that are touched are grasped anew
NEARER = 1e-3  # of the distance of the effectors from their target, that a plan takes off it


def make_plan(situation: Situation, aim: Aim, cuts: tuple[CutPlan | None, ...]) -> Plan:
    """Pose and solve (T1) until no candidate in range is predicted deeper than the tolerance.

    Holding is always among what the position limits allow, so that a slack cable whose path has become
    shorter than its winch can follow stands in nobody's way. Where other limits leave nothing, those in
    conflict are relaxed as little as possible; the status is RELAXED then.

    Where contacts in range have friction, plans count on a share of it, and on all of it where no exact
    forces of holding are found with the share. Where such a plan brings effectors that are not at their
    target no nearer, and no new contact touches or an object is far from its target, another one with the
    nearest candidates in range and without rates looks for contact; where that finds none and a limit of
    contact forces is reached, the status is OK. Where the hold has no exact forces, the friction of the last
    step is a load. A search that was cut goes on where it was. Each cluster with friction has a plan of its
    own, and the others have one together; where all are usable, one is made of them.

    Args:
        situation: what the plan starts from and what bounds it.
        aim: targets of the effector rows.
        cuts: where the searches of the last plan were cut (`Plan.cuts`); empty: there was none.
    """
    prepared, clusters = situation.prepared, situation.prepared.clusters
    if not prepared.farther.frictional:
        return plan_from(situation, aim, prepared.held.step, situation.robot.h)
    kept = dict(enumerate(cuts))
    if len(clusters.each) == 1:
        return _with_friction(situation, replace(aim, cut=kept.get(0)), 0)
    made, ends = list[tuple[Bools, Plan]](), dict[int, CutPlan | None]()
    numbers, others = np.arange(len(clusters.each)), ~clusters.rubbing
    for number in np.flatnonzero(clusters.rubbing).tolist():
        own = numbers == number
        alone = _holding(situation, ~own)
        if not _any_free(alone):
            others |= own  # their targets are missed by what is locked
            continue
        own_aim = replace(aim.among(clusters, own), cut=kept.get(number))
        plan = _with_friction(alone, own_aim, number)
        made.append((own, plan))
        (ends[number],) = plan.cuts
    beside = _holding(situation, ~others)
    if others.any() and _any_free(beside):
        grasp = aim.among(clusters, ~clusters.rubbing).grasp
        rest = replace(aim.among(clusters, others), grasp=grasp)
        made.append((others, plan_from(beside, rest, _loaded(prepared), situation.robot.h)))
    unusable = [plan for _, plan in made if not plan.status.usable]
    plan = unusable[0] if unusable else _joined(clusters, made)
    return replace(plan, cuts=tuple(map(ends.get, numbers.tolist())))


def _with_friction(situation: Situation, aim: Aim, number: int) -> Plan:
    """A plan with the friction of contacts, and where it brings nothing nearer one that looks for contact.

    Args:
        situation: what the plan starts from; actuators of other clusters hold.
        aim: targets of the effector rows; those of other clusters do not count.
        number: of the cluster.
    """
    robot, prepared, settings = situation.robot, situation.prepared, situation.settings
    resumed = aim.cut is not None and aim.cut.seeking
    first = replace(aim, cut=CutPlan(ALL_TRIED)) if resumed else aim
    step = with_known_columns(prepared.farther, prepared.held.step, aim.pushed)
    apart = distance_left(aim, prepared.held)
    plan = plan_from(situation, first, step, robot.h)
    met = plan.status is Status.SEEKING_CONTACT and apart <= MET * robot.part_size
    plan = replace(plan, status=Status.OK) if met else plan
    known = prepared.held.step.frictional and settings.friction_share < 1.0
    if plan.status is Status.NOT_FOUND and known:  # the forces of holding with all of the friction
        every = replace(situation, settings=replace(settings, friction_share=1.0))
        plan = plan_from(every, first, step, robot.h)
    if plan.status is Status.NOT_FOUND:
        return plan_from(situation, first, _loaded(prepared), robot.h)
    contacts = step.rows.contacts
    (own,) = np.nonzero(prepared.clusters.of_pairs[contacts.pair] == number)
    lost = robot.contacts.loose and apart > FAR * robot.part_size
    idle = lost or not np.isin(plan.predicted.step.extra, own).any()
    idle = idle and not brings_nearer(robot, aim, plan, apart)
    if not idle and plan.status is not Status.SEEKING_CONTACT:
        return plan
    if not (resumed or settings.time is None or settings.time.allows()):
        return replace(plan, cuts=(CutPlan(None, seeking=True),))
    near = own[np.argsort(contacts.rows.delta[own], kind="stable")[:NEAREST]]
    if len(near := np.setdiff1d(near, step.extra)) > 0:
        step = step.with_unit_columns(near)
    hidden = plan.status is Status.SEEKING_CONTACT
    aim = replace(aim, cut=aim.cut if resumed else None, looking=aim.looking or hidden)
    search = replace(situation, settings=replace(settings, seeking=hidden))
    seeking = plan_from(search, aim, step, ENDLESSLY)
    cuts = tuple([None if cut is None else replace(cut, seeking=True) for cut in seeking.cuts])
    if seeking.status.usable and brings_nearer(robot, aim, seeking, apart):
        relaxed = seeking.status is Status.RELAXED  # of the two, what a user must know
        status = Status.RELAXED if relaxed else Status.SEEKING_CONTACT
        return replace(seeking, status=status, cuts=cuts)
    if hidden and _presses_as_it_may(prepared, plan, aim.grasp):
        return replace(plan, status=Status.OK, cuts=cuts)
    return replace(plan, cuts=cuts)


def _loaded(prepared: Prepared) -> CondensedStep:
    """The step over the horizon with the friction of the last step as a load."""
    loaded = prepared.held.step
    return under_friction(prepared.farther, prepared.forces) if loaded.frictional else loaded


def _holding(situation: Situation, kept: Bools) -> Situation:
    """The same where what is not locked in some clusters (c,) keeps its effort, wherever that leads."""
    robot, prepared, locks = situation.robot, situation.prepared, situation.locks
    rows, limits = kept[prepared.clusters.of_actuators], robot.limits  # (n_a,)
    locks = no_locks(len(rows)) if locks is None else locks
    rows &= ~(locks.by_position | locks.by_force)
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


def _joined(clusters: Clusters, made: list[tuple[Bools, Plan]]) -> Plan:
    """One plan of several, in each of which some clusters (c,) are decided and the others hold.

    Contact forces are those of the first.
    """
    (_, plan), *more = made
    for own, other in more:
        rows, actuators = own[clusters.of_effectors], own[clusters.of_actuators]
        one, two, n = plan.predicted, other.predicted, len(rows) + len(actuators)
        delta, lam, both = one.delta.copy(), one.lam.copy(), np.concatenate([rows, actuators])
        delta[:n] = np.where(both, two.delta[:n], delta[:n])
        lam[:n] = np.where(both, two.lam[:n], lam[:n])
        effort = np.where(actuators, two.effort, one.effort)
        known, found = plan.certificate, other.certificate
        worse = replace(
            known,
            primal=max(known.primal, found.primal),
            complementarity=max(known.complementarity, found.complementarity),
            stationarity=max(known.stationarity, found.stationarity),
        )
        plan = replace(
            plan,
            predicted=replace(one, delta=delta, lam=lam, effort=effort),
            status=_worse(plan.status, other.status),
            certificate=worse,
            conflict=tuple(dict.fromkeys((*plan.conflict, *other.conflict))),
            held_to=np.where(rows, other.held_to, plan.held_to),
            pushed=np.concatenate([plan.pushed, other.pushed]),
        )
    return plan


def _worse(one: Status, other: Status) -> Status:
    """Of the statuses of two usable plans the one to be known: SEEKING_CONTACT, else what is not OK."""
    if Status.SEEKING_CONTACT in (one, other):
        return Status.SEEKING_CONTACT
    return other if one is Status.OK else one


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
