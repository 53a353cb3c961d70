"""What can be said of a solution of contact with friction, without the method that found it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.friction.problem import FrictionProblem, into_cone
from tauten.model.numerics import Array, Bools, kernel

RANK = 1e-10  # eigenvalues below this, relative to the largest, count as zero
STILL = 1e-7  # of the largest |q|, slip that counts as none
PROJECTIONS = 2000  # on cones and null space, by default
NONE = 1e-3  # of unit normal forces; a nearest point that is smaller is zero
WITHIN = 1e-4  # of the mean normal force, by which a point may lie beside the cones


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
        jammed: whether forces of any size in the cones of the closed contacts hold each other: the null
            space of their W meets the cones.
        motion_indeterminate: whether the motion may be another one with the same forces before: a closed
            contact opens under its own force where it slips in some direction d, w_nn − μ w_nt·d < 0.
    """

    error: float
    cone: float
    angle: float
    work: float
    closed: Bools
    sticking: Bools
    margin: Array
    indeterminate: bool
    jammed: bool
    motion_indeterminate: bool = False

    @property
    def least_margin(self) -> float:
        """Distance to slip of the sticking contact that is nearest to it [unit of r]; +inf without one."""
        return float(self.margin[self.sticking].min(initial=np.inf))

    @property
    def doubts(self) -> tuple[str, ...]:
        """What is not unique, in words."""
        said = (
            (self.indeterminate, "forces indeterminate"),
            (self.jammed, "jammed"),
            (self.motion_indeterminate, "motion may be indeterminate"),
        )
        return tuple(words for holds, words in said if holds)


def certify_friction(
    problem: FrictionProblem, r: Array, projections: int = PROJECTIONS
) -> FrictionCertificate:
    """The certificate of contact forces.

    Stick and slip are told apart by the motion, so that a solution must be accurate before they are.

    Args:
        problem: the contacts.
        r: (m d,) forces.
        projections: on cones and null space, at most, by which contacts that are jammed are found.
    """
    shape = (len(problem.mu), problem.dim)
    u, forces = (problem.W @ r + problem.q).reshape(shape), r.reshape(shape)
    pushed, slip = forces[:, 1:], u[:, 1:]
    friction, speed = np.linalg.norm(pushed, axis=1), np.linalg.norm(slip, axis=1)
    largest = float(np.abs(problem.q).max())
    closed = forces[:, 0] * problem.compliance > STILL * largest
    moving = speed > STILL * largest
    sticking = closed & ~moving
    slipping = closed & moving & (friction > 0.0)
    opposite = -np.einsum("ij,ij->i", pushed, slip)[slipping] / (friction * speed)[slipping]
    reserve = problem.mu * forces[:, 0] - friction
    rows = np.flatnonzero(closed.repeat(problem.dim))
    values, vectors = np.linalg.eigh(problem.W[rows[:, None], rows])
    null = vectors[:, values <= RANK * values.max(initial=0.0)]
    return FrictionCertificate(
        error=problem.error(r),
        cone=float(np.max(-reserve)),
        angle=float(np.arccos(np.clip(opposite, -1.0, 1.0)).max(initial=0.0)),
        work=float((pushed * slip).sum()),
        closed=closed,
        sticking=sticking,
        margin=np.where(sticking, reserve, 0.0),
        indeterminate=null.shape[1] > 0,
        jammed=_meets_cones(np.ascontiguousarray(null), problem.mu[closed], projections),
        motion_indeterminate=bool((_opening(problem) & closed).any()),
    )


def _opening(problem: FrictionProblem) -> Bools:
    """Contacts (m,) that slip in some direction would open under their own force: μ |w_nt| > w_nn.

    With r_t = −μ d r_n the gap of a contact changes by (w_nn − μ w_nt·d) r_n; where that is negative for a
    direction d, slip and stick, or slip and opening, may both solve the law (Painlevé's paradox).
    """
    normal = np.arange(len(problem.mu)) * problem.dim
    across = [problem.W[normal, normal + j] for j in range(1, problem.dim)]
    found: Bools = problem.mu * np.linalg.norm(across, axis=0) > problem.W[normal, normal]
    return found


@kernel
def _meets_cones(null: Array, mu: Array, projections: int) -> bool:
    """Whether a subspace has forces in the cones that are not all zero.

    The point of the subspace within the cones that is nearest to unit normal forces is zero exactly where
    there are none, since the normal forces of all others have a positive sum. Dykstra's projections lead to
    it (Boyle and Dykstra, Advances in Order Restricted Statistical Inference, 1986).

    Args:
        null: (m d, z) an orthonormal basis of the subspace.
        mu: (m,) coefficients of friction.
        projections: at most.
    """
    m, size = len(mu), null.shape[0]
    if null.shape[1] == 0:
        return False
    d = size // m
    near, offset = np.zeros(size), np.zeros(size)  # offset of the cones; a subspace needs none
    near[::d] = 1.0
    for _ in range(projections):
        inside = near + offset
        for i in range(m):
            into_cone(inside[i * d : (i + 1) * d], mu[i])
        offset += near - inside
        near = np.dot(null, np.dot(null.T, inside))
        total, outside = near[::d].sum(), 0.0
        if total < NONE * m:
            return False
        for i in range(m):
            across = np.sqrt((near[i * d + 1 : (i + 1) * d] ** 2).sum())
            outside = max(outside, across - mu[i] * near[i * d])
        if outside <= WITHIN * total / m:
            return True
    return False
