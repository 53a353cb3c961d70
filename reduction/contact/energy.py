"""Contact modes of least energy: a factorisation in the energy norm of the robot.

‖S − Ψ B‖ weights all forces equally, wherever they act. Their effects differ: forces on the same nodes are
equivalent, and forces on a soft part move the robot more than those near its base. Reduced contact loses the
energy f(Ψ β) − f(λ) at an equilibrium, see (T4), and the best basis of k modes is

    min Σ_j w_j [ f_j(Ψ β_j) − f_j(λ_j) ]   over Ψ ≥ 0, β_j ≥ 0                        (T5)

with w_j = 1 / |f_j(λ_j)|, which gives weak and strong contacts the same weight. In every β_j this is an LCP,
in every column of Ψ a nonnegative quadratic program: the block coordinate descent of HALS, whose error never
increases, in the norm of W instead of the identity and with the gaps as linear term.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tauten.model.numerics import Array, Ints, kernel
from tauten.reduction.contact.problems import ContactProblem

TOLERANCE = 3e-3  # relative decrease at which the sweeps end
MAX_SWEEPS = 40
_PASSES = 20  # of coordinate descent over one column
_FLOOR = 1e-3  # smallest energy in a weight, relative to the largest: limits the weight of first contacts


def refine(
    Psi: Array, problems: Sequence[ContactProblem], max_sweeps: int = MAX_SWEEPS
) -> tuple[Array, Array]:
    """Reduce the lost energy (T5) of a basis by block coordinate descent.

    Args:
        Psi: (n_c, k) modes to start from, nonnegative.
        problems: equilibria with contact.
        max_sweeps: largest number of sweeps over all modes.

    Returns:
        Psi (n_c, k), unit columns; history (sweeps + 1,), √ of the lost share of the energy at the start
        and after every sweep.

    Source: block coordinate descent of Cichocki and Phan, IEICE Trans. Fundamentals E92-A, 2009, on
    the energy of Signorini's problem (Kikuchi and Oden, Contact Problems in Elasticity, 1988, chapter 2).
    """
    # a fixed order, so that the order of the snapshots does not change the rounding
    problems = sorted(problems, key=lambda problem: (problem.energy, problem.lam.tobytes()))
    weights = _weights(problems)
    Psi = Psi / np.linalg.norm(Psi, axis=0)  # (n_c, k)
    B = _coefficients(Psi, problems)  # (k, p)
    history = [_lost(Psi, B, problems, weights)]
    for _ in range(max_sweeps):
        better = Psi.copy()
        for mode in range(Psi.shape[1]):
            _improve(better, B, mode, problems, weights)
        better /= np.linalg.norm(better, axis=0)
        B = _coefficients(better, problems)
        lost = _lost(better, B, problems, weights)
        if lost > history[-1]:  # the force of a mode vanished in some problem
            break
        Psi = better
        history.append(lost)
        if history[-2] - lost <= TOLERANCE * lost:
            break
    return Psi, np.array(history)


def energy_error(Psi: Array, problems: Sequence[ContactProblem]) -> float:
    """√ of the share of the energy (T5) lost by a basis Psi (n_c, k): 0 exact, 1 without contact forces."""
    return _lost(Psi, _coefficients(Psi, problems), problems, _weights(problems))


def worst_forces(Psi: Array, problems: Sequence[ContactProblem], count: int) -> Array:
    """Contact forces of the problems in which a basis loses most: (n_c, count), or as many as there are.

    Args:
        Psi: (n_c, k) modes.
        problems: equilibria with contact.
        count: number of problems.
    """
    losses = [problem.loss(problem.forces(Psi)) for problem in problems]
    order = np.argsort(-_weights(problems) * np.array(losses), kind="stable")[:count]
    forces = np.zeros((len(Psi), len(order)))
    for column, j in enumerate(order.tolist()):
        forces[problems[j].slots, column] = problems[j].lam
    return forces


def _weights(problems: Sequence[ContactProblem]) -> Array:
    energy = np.array([problem.energy for problem in problems])  # (p,)
    weights: Array = 1.0 / np.maximum(energy, _FLOOR * energy.max())
    return weights / float(weights @ energy)


def _coefficients(Psi: Array, problems: Sequence[ContactProblem]) -> Array:
    """Coefficients β of reduced contact, a column a problem: (k, p) [N]."""
    return np.stack([problem.coefficients(Psi) for problem in problems], axis=1)


def _lost(Psi: Array, B: Array, problems: Sequence[ContactProblem], weights: Array) -> float:
    losses = [problem.loss(Psi[problem.slots] @ B[:, j]) for j, problem in enumerate(problems)]
    return float(np.sqrt(max(weights @ np.array(losses), 0.0)))


def _improve(
    Psi: Array, B: Array, mode: int, problems: Sequence[ContactProblem], weights: Array
) -> None:
    """Minimise (T5) over one column of Psi, in place."""
    n_c = len(Psi)
    Q, slope = np.zeros((n_c, n_c)), np.zeros(n_c)  # of the quadratic program, at Psi as it is
    for j in np.flatnonzero(B[mode] > 0.0).tolist():
        problem = problems[j]
        gap = problem.delta + problem.W @ (Psi[problem.slots] @ B[:, j])  # (m,)
        weight = weights[j] * B[mode, j]
        _add(Q, slope, problem.W, gap, problem.slots, weight * B[mode, j], weight)
    column = Psi[:, mode].copy()
    _descend(column, slope, Q)
    if column.any():  # a mode without any force would have no direction: keep the old one
        Psi[:, mode] = column


@kernel
def _add(
    Q: Array, slope: Array, W: Array, gap: Array, slots: Ints, weight: float, share: float
) -> None:
    """Q[slots, slots] += weight W, slope[slots] += share gap."""
    for i in range(len(slots)):
        slope[slots[i]] += share * gap[i]
        for j in range(len(slots)):
            Q[slots[i], slots[j]] += weight * W[i, j]


@kernel
def _descend(x: Array, slope: Array, Q: Array) -> None:
    """Coordinate descent on ½ dᵀ Q d + slopeᵀ d, x + d ≥ 0; x becomes x + d, slope is overwritten."""
    for _ in range(_PASSES):
        for i in range(len(x)):
            if Q[i, i] > 0.0:
                step = max(-slope[i] / Q[i, i], -x[i])
                if step != 0.0:
                    x[i] += step
                    slope += step * Q[i]
