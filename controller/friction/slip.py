"""Slip of contacts that carry, in the objective of a plan.

Plans count on a share of the friction, so that what is held does not slip with a little less of it. To such a
plan slip looks like a means: where an object is above its target, it loosens the grasp until the object would
slide down with that share, by as much as is wanted. With all of the friction the object stays where it is, at
the edge of what holds it, and so does the next plan. Where it counts on an object that slides while it is
lifted, it lifts it too far. With a small weight on slip a plan moves the actuators instead wherever they can
do the same: both terms are zero at the target.

A plan that looks for contact has this weight on all contacts that it may touch: without it, fingers that
turn by far more than the object is to move are as good as fingers that close on it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.controller.qpcc import Qpcc
from tauten.model import CondensedStep, Forces, unit_start

WEIGHT = 0.1  # of the mean square of the slip against the square of the distance from a target


def with_slip(
    problem: Qpcc, step: CondensedStep, previous: Forces, scale: float, seeking: bool = False
) -> Qpcc:
    """An inverse problem with the slip of contacts that pushed in the last step and that efforts move.

    What efforts do not move, as an object on a floor, is not carried by its contacts.

    Args:
        problem: whose last rows are those of the unit columns of the step.
        step: the step, in which contacts in range have friction.
        previous: forces of the last step.
        scale: largest weight times unit of an effector row that the plan counts.
        seeking: whether the slip of contacts that nothing touches yet counts, too.
    """
    normal = unit_start(step, previous)[::3]  # (k,)
    u = len(problem.m) - 3 * len(normal) + 3 * np.arange(len(normal))[:, None] + np.arange(3)
    moved = problem.M[u, : len(problem.lb)].any(axis=(1, 2))  # (k,)
    carrying = u[((normal > 0.0) | seeking) & moved, 1:].ravel()  # (2 s,)
    if len(carrying) == 0:
        return problem
    M, m = problem.M[carrying], problem.m[carrying]
    weight = 2.0 * WEIGHT * scale**2 / len(carrying)
    return replace(
        problem,
        Q=problem.Q + weight * (M.T @ M),
        c=problem.c + weight * (m @ M),
        constant=problem.constant + 0.5 * weight * float(m @ m),
    )
