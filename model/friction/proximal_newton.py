"""Exact Coulomb cones: semismooth Newton steps around a proximal point.

W is singular where contacts are redundant, and Newton's method on (F1) then fails. A round therefore solves

    u = (W + α I) r + (q − α r_k)

from the last round's r_k, each contact scaled by its compliance, and its solution is r_{k+1}; a fixed point
is a solution for every α > 0 (Rockafellar, SIAM Journal on Control and Optimization 14, 1976; Acary, Brémond
and Huber, *On Solving Contact Problems with Coulomb Friction*, 2018). α becomes smaller where a round
succeeds and larger where it fails; then the weight of the residual changes too, because Newton's steps that
cycle between pieces of one residual mostly do not with another weight.

The weight says whether forces or velocities tell which contacts push and slip. Forces that are zero at first
tell nothing, and a weight of one is best. From nearly a solution a large weight takes half the
steps where contacts are redundant: their forces are far from unique, their velocities are not. Steps of a
simulation do not start so: contacts that open and close decide there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.model.friction.alart_curnier import newton_step, residual
from tauten.model.friction.problem import Cones, error_of
from tauten.model.numerics import Array, kernel

WIDEST, LEAST = 1e-1, 1e-14  # α at a start from zero, and the smallest
WARM = 3e-2  # α from forces that are nearly a solution
EASIER, HARDER = 0.1, 5.0  # factors of α after a round that succeeds, and one that fails
ROUND_STEPS = 15  # Newton steps of a round, at most
LAST_STEPS = 3  # the same where forces are accepted, but not yet as exact as is asked for
ROUND_ERROR = 1e-2  # of the error before a round; its residual at the end
WEIGHTS = (1.0, 3.0, 0.3)  # c of (F1)
WARM_WEIGHTS = (30.0, 3.0, 0.3)  # the same from forces that are nearly a solution
HALVINGS = 10  # of a Newton step
ARMIJO = 1e-4
MEMORY = 4  # squares of residuals that a step may not exceed


class NewtonForces(NamedTuple):
    """What the steps arrive at.

    Attributes:
        r: (m d,) forces, the best ones.
        error: of the natural map, in the unit of q.
        newton: linear systems; a round without one counts as one.
        rounds: of the proximal point.
    """

    r: Array
    error: float
    newton: int
    rounds: int


@kernel
def newton_forces(
    cones: Cones, start: Array, error: float, accepted: float, budget: int, warm: bool
) -> NewtonForces:
    """Contact forces by rounds of Newton steps; the best ones found, whether they are exact or not.

    Args:
        cones: the contacts.
        start: (m d,) forces to start from.
        error: of the natural map that is enough [unit of q].
        accepted: the same where a round fails: contacts that are redundant may come near and no nearer.
        budget: Newton steps, at most.
        warm: whether the start is nearly a solution.
    """
    largest = np.abs(cones.q).max()
    r, now = start, error_of(cones, start)
    newton, rounds, failures = 0, 0, 0
    widest, weights = (WARM, WARM_WEIGHTS) if warm else (WIDEST, WEIGHTS)
    alpha = widest * min(now / largest, 1.0) if largest > 0.0 else widest
    best, least = r, now
    while not now <= error and newton < budget:
        weight = weights[failures % len(weights)]
        limit = min(ROUND_STEPS if now > accepted else LAST_STEPS, budget - newton)
        tried, steps, solved = newton_round(cones, r, alpha, weight, now, limit)
        found = error_of(cones, tried)
        newton, rounds = newton + max(steps, 1), rounds + 1
        if found < least:
            best, least = tried, found
        if solved or found < 0.5 * now:
            r, now, alpha = tried, found, max(EASIER * alpha, LEAST)
        else:
            if least <= accepted:
                break
            failures, alpha = failures + 1, HARDER * alpha
    return NewtonForces(best, least, newton, rounds)


@kernel
def newton_round(
    cones: Cones, start: Array, alpha: float, c: float, error: float, limit: int
) -> tuple[Array, int, bool]:
    """Newton's steps for one proximal point: forces (m d,), steps, and whether they converged.

    Args:
        cones: the contacts.
        start: (m d,) forces of the start, the proximal point.
        alpha: weight of the distance from it, where every contact has a compliance of one.
        c: weight of the velocities in the residual.
        error: of the start [unit of q].
        limit: steps, at most.
    """
    W, q, mu, W_ii = cones
    rows, m = len(q), len(mu)
    shape = (m, rows // m)
    root, V = np.empty(rows), np.empty((rows, rows))  # V is W with scaled contacts, and α
    for i in range(rows):
        root[i] = np.sqrt(W_ii[i // shape[1]])
    for i in range(rows):
        for j in range(rows):
            V[i, j] = W[i, j] / root[i] / root[j]
        V[i, i] += alpha
    r = root * start
    u, F = np.dot(V, r) + (q / root - alpha * r), np.empty(shape)
    squares = np.zeros(MEMORY)
    squares[0] = residual(u.reshape(shape), r.reshape(shape), mu, c, F)
    # û has μ times the slip, which the residual has not
    enough = ROUND_ERROR * error / (1.0 + mu.max())
    for step in range(limit):
        if np.abs(F.ravel() * root).max() <= enough:
            return r / root, step, True
        solved, dr = newton_step(u.reshape(shape), r.reshape(shape), mu, c, V, F)
        if not solved:
            return r / root, step + 1, False
        du, t, least, share = np.dot(V, dr), 1.0, np.inf, 0.0
        for _ in range(HALVINGS):
            square = residual((u + t * du).reshape(shape), (r + t * dr).reshape(shape), mu, c, F)
            if square < least or (square == least and t < share):
                least, share = square, t
            if square <= (1.0 - ARMIJO * t) * squares.max():
                break
            t *= 0.5
        u, r = u + share * du, r + share * dr
        squares[(step + 1) % MEMORY] = residual(u.reshape(shape), r.reshape(shape), mu, c, F)
    return r / root, limit, bool(np.abs(F.ravel() * root).max() <= enough)
