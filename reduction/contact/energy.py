"""Contact modes of least energy: a factorisation in the norm that the robot itself measures with.

‖S − Ψ B‖ counts every newton alike, wherever it presses. The robot does not: forces that press on the same
nodes are alike to it, forces on a soft flank move it more than those at a root. What reduced contact
loses at an equilibrium is f(Ψ β) − f(λ), see (T4), and the best basis of k modes is

    min Σ_j w_j [ f_j(Ψ β_j) − f_j(λ_j) ]   over Ψ ≥ 0, β_j ≥ 0                        (T5)

with w_j = 1 / |f_j(λ_j)|, so that weak contacts count as much as strong ones. In every β_j this is an LCP, in
every column of Ψ a nonnegative quadratic program: the block coordinate descent of HALS, which never
ascends, in the norm of W instead of the identity, with the gaps of what does not touch as a price.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tauten.model.numerics import Array, Ints, kernel
from tauten.reduction.contact.problems import ContactProblem

TOLERANCE = 3e-3  # relative gain below which a sweep is the last
MAX_SWEEPS = 40
_PASSES = 20  # of coordinate descent over one column
_FLOOR = 1e-3  # of the largest energy: the first touch shall not outweigh the rest


def refine(
    Psi: Array, problems: Sequence[ContactProblem], max_sweeps: int = MAX_SWEEPS
) -> tuple[Array, Array]:
    """Descend from a basis to one that loses less energy (T5).

    Args:
        Psi: (n_c, k) modes to start from, nonnegative.
        problems: equilibria with contact.
        max_sweeps: sweeps over all modes at most.

    Returns:
        Psi (n_c, k), unit columns; history (sweeps + 1,), √ of the lost share of the energy after every
        sweep, the start first.

    Source: block coordinate descent of Cichocki and Phan, IEICE Trans. Fundamentals E92-A, 2009, on
    the energy of Signorini's problem (Kikuchi and Oden, Contact Problems in Elasticity, 1988, chapter 2).
    """
    # one order, so that sums round alike whatever order the snapshots came in
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
        if lost > history[-1]:  # a mode shrank to rounding in some problem, and its force with it
            break
        Psi = better
        history.append(lost)
        if history[-2] - lost <= TOLERANCE * lost:
            break
    return Psi, np.array(history)


def energy_error(Psi: Array, problems: Sequence[ContactProblem]) -> float:
    """√ of the share of the energy (T5) that a basis Psi (n_c, k) loses: 0 exact, 1 no contact."""
    return _lost(Psi, _coefficients(Psi, problems), problems, _weights(problems))


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
    if column.any():  # a mode that nothing wants stays what it is
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
    """Coordinate descent on ½ dᵀ Q d + slopeᵀ d, x + d ≥ 0; x becomes x + d, slope is spoilt."""
    for _ in range(_PASSES):
        for i in range(len(x)):
            if Q[i, i] > 0.0:
                step = max(-slope[i] / Q[i, i], -x[i])
                if step != 0.0:
                    x[i] += step
                    slope += step * Q[i]
