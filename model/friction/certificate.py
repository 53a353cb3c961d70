"""What can be said of a solution of contact with friction, without the method that found it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.friction.problem import FrictionProblem
from tauten.model.numerics import Array, Bools

RANK = 1e-10  # eigenvalues below this, relative to the largest, count as zero
STILL = 1e-7  # of the largest |q|, slip that counts as none


@dataclass(frozen=True, slots=True)
class FrictionCertificate:
    """Each number by its name; m contacts.

    Attributes:
        error: of the natural map over all contacts [unit of q].
        cone: largest |r_t| − μ r_n [unit of r].
        angle: largest angle between slip and −r_t of slipping contacts [rad].
        work: of friction, Σ r_tᵀ u_t; never positive in a solution.
        closed: (m,) contacts that push.
        sticking: (m,) those of them that do not slip.
        margin: (m,) distance to slip μ r_n − |r_t| of sticking contacts, 0 of others [unit of r].
        indeterminate: whether other forces give the same motion: W of the closed contacts is singular.
    """

    error: float
    cone: float
    angle: float
    work: float
    closed: Bools
    sticking: Bools
    margin: Array
    indeterminate: bool


def certify_friction(problem: FrictionProblem, r: Array) -> FrictionCertificate:
    """The certificate of contact forces.

    Stick and slip are told apart by the motion, so that a solution must be accurate before they are.

    Args:
        problem: the contacts.
        r: (m d,) forces.
    """
    shape = (len(problem.mu), problem.dim)
    u, forces = (problem.W @ r + problem.q).reshape(shape), r.reshape(shape)
    pushed, slip = forces[:, 1:], u[:, 1:]
    friction, speed = np.linalg.norm(pushed, axis=1), np.linalg.norm(slip, axis=1)
    largest = float(np.abs(problem.q).max())
    closed = forces[:, 0] * problem.diagonal > STILL * largest
    moving = speed > STILL * largest
    sticking = closed & ~moving
    slipping = closed & moving & (friction > 0.0)
    opposite = -np.einsum("ij,ij->i", pushed, slip)[slipping] / (friction * speed)[slipping]
    reserve = problem.mu * forces[:, 0] - friction
    rows = np.flatnonzero(closed.repeat(problem.dim))
    values = np.linalg.eigvalsh(problem.W[rows[:, None], rows]) if len(rows) else np.ones(1)
    return FrictionCertificate(
        error=problem.error(r),
        cone=float(np.max(-reserve)),
        angle=float(np.arccos(np.clip(opposite, -1.0, 1.0)).max(initial=0.0)),
        work=float((pushed * slip).sum()),
        closed=closed,
        sticking=sticking,
        margin=np.where(sticking, reserve, 0.0),
        indeterminate=bool(values[0] <= RANK * values[-1]),
    )
