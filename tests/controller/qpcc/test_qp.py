"""One convex QP: every library gives the same answer."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.controller.qpcc import (
    UNBOUNDED,
    KeptQp,
    Qp,
    QpAnswer,
    available_backends,
    qp_backend,
    solve_daqp,
)

pytestmark = pytest.mark.versions

BACKENDS = available_backends()
ACCURACY = {"daqp": 1e-9, "quadprog": 1e-9}  # the others stop at tolerances of their own


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
    assert "osqp" in BACKENDS


@pytest.mark.parametrize("name", BACKENDS)
def test_back_ends_agree(name: str) -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        qp = random_qp(rng)
        answer = qp_backend(name)(qp)
        assert not answer.infeasible
        assert kkt_residual(qp, answer) < ACCURACY.get(name, 1e-3)
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
    assert answer.infeasible or kkt_residual(qp, answer) > 1e-3


def test_an_unknown_back_end_is_refused_with_the_choice() -> None:
    with pytest.raises(ValueError, match=r"'nope' is not installed, found are daqp"):
        qp_backend("nope")


@pytest.mark.parametrize("rank", [None, 2])
def test_a_kept_qp_is_the_qp_with_another_slope(rank: int | None) -> None:
    rng = np.random.default_rng(4)
    for _ in range(10):
        qp = random_qp(rng, rank=rank)
        kept = KeptQp(qp)
        assert kept.usable
        for _ in range(5):
            f = rng.normal(size=4)
            other = Qp(qp.H, f, qp.A, qp.lower, qp.upper)
            found, y = kept.solve(f)
            assert found
            expected = solve_daqp(other).y
            assert y @ (0.5 * qp.H @ y + f) == pytest.approx(
                expected @ (0.5 * qp.H @ expected + f), abs=1e-7
            )


def test_singular_qps_are_exact() -> None:
    rng = np.random.default_rng(2)
    for _ in range(50):
        qp = random_qp(rng, rank=2)
        assert kkt_residual(qp, solve_daqp(qp)) < 1e-8
