"""Plans with exact effectors: how near these come where no efforts bring them to their targets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.controller.planning.inverse import Aim
from tauten.controller.planning.plan import Plan
from tauten.controller.planning.posing import EXACTLY
from tauten.controller.planning.prepared import Situation
from tauten.controller.planning.seeking import make_plan
from tauten.controller.qpcc import NO_PIECE, Status
from tauten.model import PredictedStep, Robot
from tauten.model.numerics import Array, Bools


def with_exact_rows(situation: Situation, aim: Aim, plan: Plan) -> Plan:
    """The plan of a robot with exact effectors, NOT_EXACT where some cannot meet their targets.

    Where no efforts meet all of them, their distance is made as small as possible and the others follow from
    what remains. Where they are missed because what moves them is locked, `conflict` names them.

    Args:
        situation: what it starts from and what bounds it.
        aim: with the rows of exact effectors as equations.
        plan: of this aim, usable or not.
    """
    if not plan.status.usable:
        plan = _nearest(situation, aim, plan.conflict)
    clusters, locks = situation.prepared.clusters, situation.locks
    if plan.status is not Status.OK or locks is None:
        return plan
    free = clusters.of_actuators[~(locks.by_position | locks.by_force)]
    idle = ~np.isin(clusters.of_effectors, free)  # (n_e,)
    missed = missed_rows(situation.robot, plan.predicted, aim.target, idle)
    return replace(plan, status=Status.NOT_EXACT, conflict=missed) if missed else plan


def _nearest(situation: Situation, aim: Aim, conflict: tuple[str, ...]) -> Plan:
    """The plan where exact rows cannot meet their targets: these as near as possible, then the others.

    Args:
        situation: what it starts from and what bounds it.
        aim: with the rows of exact effectors as equations.
        conflict: names of the limits and rows that are in conflict.
    """
    exact, robot = aim.equations, situation.robot
    none = np.zeros_like(exact)
    alone = replace(aim, scale=np.where(exact, aim.scale, 0.0), equations=none)
    nearest = make_plan(situation, alone, ())
    if not nearest.status.usable:
        return nearest
    reached = nearest.predicted.delta[robot.layout.effectors]
    plan = nearest
    if (aim.scale[~exact] != 0.0).any():
        among = replace(aim, target=np.where(exact, reached, aim.target))
        both = make_plan(situation, among, ())
        plan = both if both.status.usable else nearest
    missed = robot.effector_layout.missed_rows(aim.target - reached)
    limits = (name for name in conflict if name not in (*missed, *NO_PIECE))
    return replace(plan, status=Status.NOT_EXACT, conflict=(*missed, *limits))


def missed_rows(robot: Robot, found: PredictedStep, target: Array, among: Bools) -> tuple[str, ...]:
    """Names of exact rows that are away from their target after a step.

    Args:
        robot: its exact effectors.
        found: the step.
        target: (n_e,) values of the rows.
        among: (n_e,) which rows are looked at.
    """
    layout = robot.effector_layout
    errors = np.where(among & layout.exact, target - found.delta[robot.layout.effectors], 0.0)
    if np.abs(layout.scale * errors).max() <= EXACTLY * robot.part_size:
        return ()
    return layout.missed_rows(errors)
