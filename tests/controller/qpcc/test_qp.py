"""One convex QP: every library gives the same answer, the polish makes rough answers exact."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.controller.qpcc import (
    UNBOUNDED,
    Qp,
    QpAnswer,
    RepeatedQp,
    available_backends,
    back_substitute,
    eliminate,
    lower_bound,
    polished,
    qp_backend,
    solve_daqp,
    solve_transposed,
)
from tauten.model.numerics import Array, Ints

BACKENDS = available_backends()


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


def kkt_residual(qp: Qp, answer: QpAnswer) -> float:
    """Of feasibility, stationarity, signs and complementary slackness."""
    rows = np.vstack([np.eye(len(qp.f)), qp.A])
    values, up = rows @ answer.y, np.maximum(answer.multipliers, 0.0)
    down = np.maximum(-answer.multipliers, 0.0)
    gradient = qp.H @ answer.y + qp.f + rows.T @ answer.multipliers
    return float(
        max(
            np.abs(gradient).max(),
            (values - qp.upper).max(),
            (qp.lower - values).max(),
            np.minimum(up, qp.upper - values).max(),
            np.minimum(down, values - qp.lower).max(),
        )
    )


def test_a_solution_by_hand() -> None:
    # nearest point of the half plane x + y >= 2 to the origin, x <= 0.5: (0.5, 1.5); multipliers from
    # (0.5, 1.5) + (a, 0) + d (1, 1) = 0: d = -1.5, a = 1
    qp = Qp(
        np.eye(2),
        np.zeros(2),
        np.ones((1, 2)),
        np.array([-UNBOUNDED, -UNBOUNDED, 2.0]),
        np.array([0.5, UNBOUNDED, UNBOUNDED]),
    )
    answer = solve_daqp(qp)
    np.testing.assert_allclose(answer.y, [0.5, 1.5], atol=1e-12)
    np.testing.assert_allclose(answer.multipliers, [1.0, 0.0, -1.5], atol=1e-12)


def test_the_default_is_the_first() -> None:
    assert BACKENDS[0] == "daqp"
    assert {"osqp", "proxqp"} <= set(BACKENDS)


@pytest.mark.parametrize("name", BACKENDS)
def test_back_ends_agree(name: str) -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        qp = random_qp(rng)
        answer = qp_backend(name)(qp)
        assert not answer.infeasible
        assert kkt_residual(qp, polished(qp, answer)) < 1e-9
        np.testing.assert_allclose(answer.y, solve_daqp(qp).y, atol=1e-3)


@pytest.mark.parametrize("name", BACKENDS)
def test_back_ends_notice_empty_sets(name: str) -> None:
    qp = Qp(
        np.eye(2),
        np.zeros(2),
        np.ones((1, 2)),
        np.array([-UNBOUNDED, -UNBOUNDED, 2.0]),
        np.array([0.5, 0.5, UNBOUNDED]),
    )
    answer = qp_backend(name)(qp)
    # some libraries only fail to converge; then the answer must not pass for a solution
    assert answer.infeasible or kkt_residual(qp, polished(qp, answer)) > 1e-3


def test_an_unknown_back_end_is_refused_with_the_choice() -> None:
    with pytest.raises(ValueError, match=r"'nope' is not installed, found are daqp"):
        qp_backend("nope")


@pytest.mark.parametrize("rank", [None, 2])
def test_the_polish_makes_rough_answers_exact(rank: int | None) -> None:
    rng = np.random.default_rng(2)
    improved = 0
    for _ in range(50):
        qp = random_qp(rng, rank=rank)
        exact = solve_daqp(qp)
        noise = 1e-6 * rng.normal(size=len(qp.f))
        rough = QpAnswer(False, exact.y + noise, exact.multipliers)
        answer = polished(qp, rough)
        assert kkt_residual(qp, rough) > 1e-8
        improved += kkt_residual(qp, answer) < 1e-9
    assert improved == 50


def test_the_polish_finds_the_active_bounds_of_a_membrane_from_nothing() -> None:
    # H is an M-matrix, for which the iteration converges from anywhere (Bergounioux, Ito, Kunisch)
    n = 30
    H = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    floor = np.sin(np.linspace(0.0, 9.0, n)) - 0.5
    qp = Qp(H, np.full(n, 0.02), np.zeros((0, n)), floor, np.full(n, UNBOUNDED))
    answer = polished(qp, QpAnswer(False, np.ones(n), np.zeros(n)))
    assert kkt_residual(qp, answer) < 1e-9
    assert 5 < np.sum(answer.multipliers < 0.0) < 25


def test_a_repeated_qp_is_the_qp_with_other_limits() -> None:
    rng = np.random.default_rng(4)
    feasible = 0
    for _ in range(10):
        qp = random_qp(rng, rank=2)
        repeated = RepeatedQp(qp)
        assert repeated.usable
        for _ in range(5):
            upper = np.maximum(qp.upper - rng.uniform(0.0, 0.5, len(qp.upper)), qp.lower)
            other = Qp(qp.H, qp.f, qp.A, qp.lower, upper)
            found, expected = repeated.solve(upper), solve_daqp(other)
            assert found.infeasible == expected.infeasible
            if not found.infeasible:
                feasible += 1
                assert value_of(qp, found) == pytest.approx(value_of(qp, expected), abs=1e-7)
    assert feasible > 10


def value_of(qp: Qp, answer: QpAnswer) -> float:
    return float(answer.y @ (0.5 * qp.H @ answer.y + qp.f))


def test_bounds_hold_whatever_the_answer_and_are_tight_at_the_solution() -> None:
    rng = np.random.default_rng(7)
    for _ in range(30):
        qp = random_qp(rng)
        exact = polished(qp, solve_daqp(qp))
        lowest = value_of(qp, exact)
        tight = lower_bound(qp, qp.upper, exact.y, exact.multipliers)
        assert tight == pytest.approx(lowest, abs=1e-9)
        y, multipliers = exact.y + rng.normal(size=4), exact.multipliers + rng.normal(size=10)
        assert lower_bound(qp, qp.upper, y, multipliers) < lowest


@pytest.mark.parametrize("slope", [1.0, 1e-6, 1e-9])
def test_what_has_no_minimum_has_no_bound(slope: float) -> None:
    # min slope·x, x unbounded below, which libraries may take for solved where the slope is small
    free, lower = np.array([UNBOUNDED, UNBOUNDED]), np.array([-UNBOUNDED, 0.0])
    qp = Qp(np.diag([0.0, 1.0]), np.array([slope, 1.0]), np.zeros((0, 2)), lower, free)
    answer = solve_daqp(qp)
    assert lower_bound(qp, free, answer.y, answer.multipliers) == -np.inf


@pytest.mark.parametrize("rank", [6, 3, 1, 0])
def test_elimination_finds_rank_and_solution(rank: int) -> None:
    rng = np.random.default_rng(5)
    matrix = rng.normal(size=(6, rank)) @ rng.normal(size=(rank, 6))
    solution = rng.normal(size=(6, 2))
    E, X = matrix.copy(), matrix @ solution
    found, rows, cols = eliminate(E, X)
    assert found == rank
    back_substitute(E, X, found)
    basic = np.zeros((6, 2))
    basic[cols[:found]] = X[:found]
    np.testing.assert_allclose(matrix @ basic, matrix @ solution, atol=1e-10)
    assert_transposed(matrix, E, rows[:found], cols[:found], rng.normal(size=found))


def assert_transposed(matrix: Array, E: Array, rows: Ints, cols: Ints, x: Array) -> None:
    """`solve_transposed` solves with the transpose of the eliminated block."""
    block = matrix[np.ix_(rows, cols)]
    y = x.copy()
    solve_transposed(E, y, len(x))
    np.testing.assert_allclose(block.T @ y, x, atol=1e-9)
