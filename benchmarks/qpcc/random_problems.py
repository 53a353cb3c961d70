"""Random QPCCs: with known solutions, like those of robots, degenerate, and nonsense.

`known_global` and `known_stationary` follow QPECgen (Jiang and Ralph 1999): choose the solution, which
pairs are active and the multipliers first, and then the data that make the optimality conditions hold.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.controller import energy_scale, inverse_problem
from tauten.controller.qpcc import Qpcc
from tauten.model import Limits, row_layout
from tauten.model.numerics import Array

Random = np.random.Generator


@dataclass(frozen=True, slots=True)
class Known:
    """A problem and a point that solves it.

    Attributes:
        problem: the QPCC.
        lam_a: (n_a,).
        beta: (k,).
    """

    problem: Qpcc
    lam_a: Array
    beta: Array


def known_global(rng: Random, n_a: int, k: int, degenerate: int = 0) -> Known:
    """A problem whose global optimum is known: all multipliers of pairs are nonnegative.

    The point then solves the convex relaxation without complementarity, so that nothing is lower.

    Args:
        rng: source of randomness.
        n_a: tensions.
        k: pairs.
        degenerate: pairs of which both sides are zero at the solution.
    """
    return with_solution(rng, n_a, k, degenerate, signs=np.ones(k))


def known_stationary(rng: Random, n_a: int, k: int, degenerate: int = 0) -> Known:
    """A problem with a known strongly stationary point, as a rule not its global optimum.

    Args:
        rng: source of randomness.
        n_a: number of tensions.
        k: number of pairs.
        degenerate: number of pairs of which both sides are zero at the point.
    """
    return with_solution(rng, n_a, k, degenerate, signs=rng.choice([-1.0, 1.0], size=k))


def with_solution(rng: Random, n_a: int, k: int, degenerate: int, signs: Array) -> Known:
    """QPECgen: multipliers of the active sides get the signs given, those of degenerate pairs are >= 0.

    Args:
        rng: source of randomness.
        n_a: number of tensions.
        k: number of pairs.
        degenerate: number of pairs of which both sides are zero at the point.
        signs: (k,) of the multipliers of the active sides.
    """
    n = n_a + k
    M = np.hstack([rng.normal(size=(k, n_a)), semidefinite(rng, k, k)])  # (k, n)
    Q = semidefinite(rng, n, max(1, n // 2)) + np.diag(np.r_[np.full(n_a, 1e-2), np.zeros(k)])
    lam_a = rng.uniform(0.0, 2.0, n_a) * (rng.random(n_a) < 0.7)
    pushes = rng.random(k) < 0.5
    both = np.zeros(k, dtype=bool)
    both[rng.permutation(k)[:degenerate]] = True
    beta = np.where(pushes & ~both, rng.uniform(0.1, 2.0, k), 0.0)
    w = np.where(~pushes & ~both, rng.uniform(0.1, 2.0, k), 0.0)
    size = rng.uniform(0.1, 1.0, (2, k))
    mu = np.where(both, size[0], np.where(pushes, signs * size[0], 0.0))  # of w
    nu = np.where(both, size[1], np.where(pushes, 0.0, signs * size[1]))  # of beta
    z = np.concatenate([lam_a, beta])
    held = np.where(lam_a == 0.0, rng.uniform(0.0, 1.0, n_a), 0.0)  # of lam_a >= 0
    c = M.T @ mu + np.concatenate([held, nu]) - Q @ z
    problem = Qpcc(
        Q=Q,
        c=c,
        lb=np.zeros(n_a),
        ub=np.full(n_a, 10.0),
        G=np.zeros((0, n)),
        g_lo=np.zeros(0),
        g_hi=np.zeros(0),
        M=M,
        m=w - M @ z,
    )
    return Known(problem, lam_a, beta)


def semidefinite(rng: Random, n: int, rank: int) -> Array:
    """A random matrix (n, n), positive semidefinite of a given rank.

    Args:
        rng: source of randomness.
        n: rows and columns.
        rank: of the matrix.
    """
    factor = rng.normal(size=(n, rank)) / np.sqrt(max(rank, 1))
    product: Array = factor @ factor.T
    return product


@dataclass(frozen=True, slots=True)
class RobotLike:
    """A random soft robot condensed to its compliances, which drifts as it moves.

    Attributes:
        W: (m, m) compliance of effector, cables and contacts [m/N].
        delta_free: (m,) their values after a step without forces [m].
        limits: of the cables.
        target: (3,) where the effector is to go [m].
        drift: (m, m) factor by which the compliance changes over a step.
        velocity: (3,) of the target [m per step].
    """

    W: Array
    delta_free: Array
    limits: Limits
    target: Array
    drift: Array
    velocity: Array

    def problem(self, step: int = 0, position_prev: Array | None = None) -> Qpcc:
        """The inverse problem of a control step."""
        turn = np.eye(len(self.drift)) + np.sin(0.1 * step) * self.drift
        n_a = len(self.limits.rate)
        position = np.zeros(n_a) if position_prev is None else position_prev
        W = turn @ self.W @ turn.T
        target = self.target + step * self.velocity
        weight = 1e-3 * energy_scale(W, row_layout(3, n_a), np.zeros(len(W) - 3 - n_a, np.bool_))
        return inverse_problem(W, self.delta_free, target, position, self.limits, 0.02, weight)


def robot_like(rng: Random, n_a: int, k: int, rank: int | None = None) -> RobotLike:
    """Rows of effector, cables and contacts on a random compliant body, 1e-4 m/N, gaps of a millimetre.

    Args:
        rng: source of randomness.
        n_a: cables.
        k: contact modes.
        rank: of the compliance; below n_a + k + 3 some modes depend on each other.
    """
    m = 3 + n_a + k
    W = 1e-4 * semidefinite(rng, m, m + 5 if rank is None else rank)
    free = np.concatenate(
        [
            rng.normal(size=3) * 0.01,
            rng.normal(size=n_a) * 1e-4,
            5e-4 + rng.normal(size=k) * 1e-3,
        ]
    )
    if rank is not None:  # gaps that contact forces can open must not contradict each other
        free[3 + n_a :] = np.abs(free[3 + n_a :])
    limits = Limits(
        effort_min=np.zeros(n_a),
        effort_max=np.full(n_a, 20.0),
        position_min=np.full(n_a, -0.005),
        position_max=np.full(n_a, 0.04),
        rate=np.full(n_a, 0.05),
    )
    return RobotLike(
        W=W,
        delta_free=free,
        limits=limits,
        target=free[:3] + rng.normal(size=3) * 0.002,
        drift=0.02 * rng.normal(size=(m, m)) / np.sqrt(m),
        velocity=rng.normal(size=3) * 2e-4,
    )


def degenerate(rng: Random, n_a: int, k: int) -> Qpcc:
    """A robot-like problem with one of the degeneracies that robots have.

    Args:
        rng: source of randomness.
        n_a: number of tensions.
        k: number of contact modes.
    """
    kind = rng.integers(6)
    if kind == 0:  # contacts that depend on each other linearly
        return robot_like(rng, n_a, k, rank=max(2, (n_a + k) // 2)).problem()
    problem = robot_like(rng, n_a, k).problem()
    n = n_a + k
    if kind == 1 and k > 1:  # duplicate modes
        twin = np.r_[0 : n - 1, n_a]
        return replace(
            problem,
            Q=problem.Q[np.ix_(twin, twin)],
            c=problem.c[twin],
            G=problem.G[:, twin],
            M=problem.M[np.r_[0 : k - 1, 0]][:, twin],
            m=problem.m[np.r_[0 : k - 1, 0]],
        )
    if kind == 2:  # the effector does not move with any force
        return replace(problem, Q=1e-16 * np.eye(n), c=np.zeros(n))
    if kind == 3:  # limits that leave one tension
        return replace(problem, ub=np.zeros(n_a))
    if kind == 4:  # all gaps closed without any force
        return replace(problem, m=np.zeros(k))
    return replace(problem, g_lo=problem.g_hi - 1e-7)  # limits almost equal


def nonsense(rng: Random, decades: float = 12.0) -> Qpcc:
    """Anything of the right shapes: infinite bounds, empty sets, zeros, NaN.

    Args:
        rng: source of randomness.
        decades: scales reach from 10 to minus this to 10 to this.
    """
    n_a, k, p = (int(rng.integers(0, top)) for top in (5, 8, 4))
    n = n_a + k

    def some(*shape: int) -> Array:
        values = rng.normal(size=shape) * 10.0 ** rng.uniform(-decades, decades)
        if rng.random() < 0.3:
            values = values * 10.0 ** rng.uniform(-decades, decades, size=shape)
        result: Array = values * (rng.random(shape) < rng.choice([0.2, 0.8, 1.0]))
        return result

    def limits(size: int) -> tuple[Array, Array]:
        low, width = some(size), np.abs(some(size))
        high = low + (width if rng.random() < 0.95 else -width)
        low[rng.random(size) < 0.2] = -np.inf
        high[rng.random(size) < 0.2] = np.inf
        return low, high

    half = some(n, n)
    contact = some(k, k)
    contact = contact @ contact.T if rng.random() < 0.7 else contact
    (lb, ub), (g_lo, g_hi) = limits(n_a), limits(p)
    M, m = np.hstack([some(k, n_a), contact]), some(k)
    if rng.random() < 0.02 and k > 0:
        m[0] = rng.choice([np.nan, np.inf])
    return Qpcc(half @ half.T, some(n), lb, ub, some(p, n), g_lo, g_hi, M, m)


def nasty(rng: Random, decades: float = 6.0) -> Qpcc:
    """A small problem that is hard on tolerances: whole numbers, low rank, gaps of zero, no curvature, units.

    Args:
        rng: source of randomness.
        decades: forces and lengths are measured in units from 10 to minus this to 10 to this.
    """
    n_a, k, p = int(rng.integers(1, 5)), int(rng.integers(1, 7)), int(rng.integers(0, 4))
    n = n_a + k
    kind = rng.integers(4)

    def some(*shape: int) -> Array:
        values = rng.normal(size=shape) if kind < 2 else rng.integers(-2, 3, size=shape)
        return np.asarray(values, dtype=np.float64)

    rank = int(rng.integers(0, n + 1))
    half, contact = some(n, rank), some(k, int(rng.integers(1, k + 1)))
    N = contact @ contact.T
    if kind == 3:  # skew, as in bilevel programs
        N = np.triu(some(k, k), 1)
        N = N - N.T
    m = some(k) * (rng.random(k) < rng.choice([0.0, 0.5, 1.0]))
    low = some(p)
    width = np.abs(some(p)) * (rng.random(p) < 0.7)
    high = np.where(rng.random(p) < 0.3, np.inf, low + width)
    force, length = 10.0 ** rng.uniform(-decades, decades, 2)
    return Qpcc(
        Q=half @ half.T * length**2 / force**2,
        c=some(n) * length**2 / force,
        lb=np.where(rng.random(n_a) < 0.2, -np.inf, 0.0),
        ub=np.where(rng.random(n_a) < 0.5, np.inf, force * np.abs(some(n_a))),
        G=some(p, n) * length / force,
        g_lo=low * length,
        g_hi=high * length,
        M=np.hstack([some(k, n_a), N]) * length / force,
        m=m * length,
    )
