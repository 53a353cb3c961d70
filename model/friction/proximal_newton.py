"""Exact Coulomb cones: semismooth Newton steps around a proximal point.

W is singular where contacts are redundant, and Newton's method on (F1) then fails. A round therefore solves

    u = (W + α I) r + (q − α r_k)

from the last round's r_k, each contact scaled by its compliance, and its solution is r_{k+1}; a fixed point
is a solution for every α > 0 (Rockafellar, SIAM Journal on Control and Optimization 14, 1976; Acary, Brémond
and Huber, *On Solving Contact Problems with Coulomb Friction*, 2018). α becomes smaller where a round
succeeds and larger where it fails; then the weight of the residual changes too, because Newton's steps that
cycle between pieces of one residual mostly do not with another weight.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.friction.alart_curnier import jacobian, residual
from tauten.model.friction.problem import FrictionProblem
from tauten.model.numerics import Array

TOLERANCE = 1e-9  # of the natural map, relative to the largest |q|
BUDGET = 100  # Newton steps
WIDEST, LEAST = 1e-1, 1e-14  # α at a start from zero, and the smallest
EASIER, HARDER = 0.1, 5.0  # factors of α after a round that succeeds, and one that fails
ROUND_STEPS = 15  # Newton steps of a round, at most
ROUND_ERROR = 1e-2  # of the error before a round; its residual at the end
WEIGHTS = (1.0, 3.0, 0.3)  # c of (F1)
HALVINGS = 10  # of a Newton step
ARMIJO = 1e-4
MEMORY = 4  # squares of residuals that a step may not exceed


@dataclass(frozen=True, slots=True)
class FrictionSolution:
    """Contact forces with friction.

    Attributes:
        r: (m d,) forces.
        u: (m d,) velocities or displacements.
        error: of the natural map, in the unit of q; see `FrictionProblem.error`.
        newton: linear systems that were solved; a round without one counts as one.
        rounds: of the proximal point.
        converged: whether the error is within the tolerance.
    """

    r: Array
    u: Array
    error: float
    newton: int
    rounds: int
    converged: bool


def solve_friction(
    problem: FrictionProblem,
    start: Array | None = None,
    tolerance: float = TOLERANCE,
    budget: int = BUDGET,
) -> FrictionSolution:
    """Solve contact with friction; the best forces found, whether they meet the tolerance or not.

    Args:
        problem: the contacts.
        start: (m d,) forces to start from, as of the last step; None: zero. They are returned where they
            hold.
        tolerance: of the natural map, relative to the largest |q|.
        budget: Newton steps, at most.
    """
    largest = float(np.abs(problem.q).max())
    r = np.zeros(len(problem.q)) if start is None else np.array(start, dtype=float)
    error, newton, rounds, failures = problem.error(r), 0, 0, 0
    alpha = WIDEST * min(error / largest, 1.0) if largest > 0.0 else WIDEST
    best = error, r
    while not error <= tolerance * largest and newton < budget:
        weight = WEIGHTS[failures % len(WEIGHTS)]
        limit = min(ROUND_STEPS, budget - newton)
        tried, steps, solved = _round(problem, r, alpha, weight, error, limit)
        found, newton, rounds = problem.error(tried), newton + max(steps, 1), rounds + 1
        if found < best[0]:
            best = found, tried
        if solved or found < 0.5 * error:
            r, error, alpha = tried, found, max(EASIER * alpha, LEAST)
        else:
            failures, alpha = failures + 1, HARDER * alpha
    error, r = best
    converged = error <= tolerance * largest
    return FrictionSolution(r, problem.W @ r + problem.q, error, newton, rounds, converged)


def _round(
    problem: FrictionProblem,
    start: Array,
    alpha: float,
    c: float,
    error: float,
    limit: int,
) -> tuple[Array, int, bool]:
    """Newton's steps for one proximal point: forces (m d,), steps, and whether they converged.

    Args:
        problem: the contacts.
        start: (m d,) forces, the proximal point.
        alpha: weight of the distance from it, where every contact has a compliance of one.
        c: weight of the velocities in the residual.
        error: of the start [unit of q].
        limit: steps, at most.
    """
    root = np.sqrt(problem.diagonal).repeat(problem.dim)  # (m d,)
    W = problem.W / root[:, None] / root
    W[np.diag_indices_from(W)] += alpha
    r, shape = root * start, (len(problem.mu), problem.dim)
    q = problem.q / root - alpha * r
    u, F = W @ r + q, np.empty(shape)
    squares = [residual(u.reshape(shape), r.reshape(shape), problem.mu, c, F)]
    # û has μ times the slip, which the residual has not
    enough = ROUND_ERROR * error / (1.0 + problem.mu.max())
    for step in range(limit):
        if np.abs(F.ravel() * root).max() <= enough:
            return r / root, step, True
        J = jacobian(u.reshape(shape), r.reshape(shape), problem.mu, c, W)
        try:
            dr = np.linalg.solve(J, -F.ravel())
        except np.linalg.LinAlgError:
            return r / root, step + 1, False
        du, t, best = W @ dr, 1.0, (np.inf, 0.0)
        for _ in range(HALVINGS):
            there = u + t * du, r + t * dr
            square = residual(there[0].reshape(shape), there[1].reshape(shape), problem.mu, c, F)
            best = min(best, (square, t))
            if square <= (1.0 - ARMIJO * t) * max(squares[-MEMORY:]):
                break
            t *= 0.5
        square, t = best
        u, r = u + t * du, r + t * dr
        squares.append(residual(u.reshape(shape), r.reshape(shape), problem.mu, c, F))
    return r / root, limit, bool(np.abs(F.ravel() * root).max() <= enough)
