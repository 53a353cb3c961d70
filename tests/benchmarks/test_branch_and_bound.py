"""Branch and bound over modes: bounds hold, proofs are those of all pieces."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.qpcc import branch_and_bound, enumerate_pieces, robot_like
from benchmarks.qpcc.global_optimum import GlobalOptimum, dual_value
from tauten.controller.qpcc import UNBOUNDED, Qp, QpAnswer, Qpcc, solve_daqp
from tauten.model.numerics import Array


def bound(qp: Qp, upper: Array, y: Array, multipliers: Array) -> float:
    return float(dual_value(qp.H, qp.f, qp.A, qp.lower, upper, y, multipliers))


def random_qp(rng: np.random.Generator, n: int = 4, m: int = 6, rank: int | None = None) -> Qp:
    """A feasible QP of order one, some limits missing, some one-sided."""
    factor = rng.normal(size=(n, n if rank is None else rank))
    A, inside = rng.normal(size=(m, n)), rng.normal(size=n)
    values = np.concatenate([inside, A @ inside])
    lower = values - rng.uniform(0.0, 1.0, n + m)
    upper = values + rng.uniform(0.0, 1.0, n + m)
    lower[n:][rng.random(m) < 0.3] = -UNBOUNDED
    upper[n:][rng.random(m) < 0.3] = UNBOUNDED
    return Qp(factor @ factor.T, rng.normal(size=n), A, lower, upper)


def value_of(qp: Qp, answer: QpAnswer) -> float:
    return float(answer.y @ (0.5 * qp.H @ answer.y + qp.f))


def test_bounds_hold_whatever_the_answer_and_are_tight_at_the_solution() -> None:
    rng = np.random.default_rng(7)
    for _ in range(30):
        qp = random_qp(rng)
        exact = solve_daqp(qp)
        lowest = value_of(qp, exact)
        tight = bound(qp, qp.upper, exact.y, exact.multipliers)
        assert tight == pytest.approx(lowest, abs=1e-9)
        y, multipliers = exact.y + rng.normal(size=4), exact.multipliers + rng.normal(size=10)
        assert bound(qp, qp.upper, y, multipliers) < lowest


@pytest.mark.parametrize("slope", [1.0, 1e-6, 1e-9])
def test_what_has_no_minimum_has_no_bound(slope: float) -> None:
    # min slope·x, x unbounded below, which libraries may take for solved where the slope is small
    free, lower = np.array([UNBOUNDED, UNBOUNDED]), np.array([-UNBOUNDED, 0.0])
    qp = Qp(np.diag([0.0, 1.0]), np.array([slope, 1.0]), np.zeros((0, 2)), lower, free)
    answer = solve_daqp(qp)
    assert bound(qp, free, answer.y, answer.multipliers) == -np.inf


def bilevel(rng: np.random.Generator) -> Qpcc:
    """A linear bilevel program with whole numbers: x leads, y >= 0 minimises d'y s.t. A y <= b - B x."""
    n_x, n_y, rows = 2, 3, 3
    A, B = rng.integers(-2, 3, (rows, n_y)), rng.integers(-2, 3, (rows, n_x))
    M = np.block([[np.zeros((n_y, n_x + n_y)), A.T], [-B, -A, np.zeros((rows, rows))]])
    n = n_x + n_y + rows
    return Qpcc(
        Q=np.zeros((n, n)),
        c=np.r_[rng.integers(-8, 5, n_x + n_y), np.zeros(rows)].astype(float),
        lb=np.zeros(n_x),
        ub=np.full(n_x, 3.0),
        G=np.eye(n)[n_x : n_x + n_y],
        g_lo=np.zeros(n_y),
        g_hi=np.full(n_y, 5.0),
        M=M.astype(float),
        m=np.r_[rng.integers(-1, 3, n_y), rng.integers(1, 4, rows)].astype(float),
    )


def test_proofs_for_bilevel_programs_are_those_of_all_pieces() -> None:
    """Relaxations with a kept workspace called feasible ones infeasible on such problems."""
    rng, proved = np.random.default_rng(1), 0
    for _ in range(60):
        problem = bilevel(rng)
        lowest, _ = enumerate_pieces(problem)
        found = branch_and_bound(problem, None, 5.0)
        if not found.proved or not np.isfinite(lowest):
            continue
        proved += 1
        assert found.bound <= lowest + 1e-6 * max(abs(lowest), 1.0)
        assert found.objective == pytest.approx(lowest, abs=1e-6)
    assert proved >= 20


def test_a_search_that_had_no_time_proves_nothing() -> None:
    """Neither that its point is the best nor that there is none: without a bound it did."""
    problem = robot_like(np.random.default_rng(0), 3, 10).problem()
    found = branch_and_bound(problem, None, 0.0)
    assert np.isfinite(found.objective) and found.bound == -np.inf
    assert not found.proved
    assert not GlobalOptimum(np.inf, -np.inf).proved
    assert not GlobalOptimum(np.inf, 1.0).proved
    assert GlobalOptimum(np.inf, np.inf).proved
