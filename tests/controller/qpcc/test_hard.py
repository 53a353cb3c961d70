"""Random problems that are hard on tolerances, cold starts of robots, and what other libraries answer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference.linear_programs import has_feasible_point, steepest_slope
from scipy.linalg import block_diag
from support.qpcc_checks import EXACT, recorded, worst

from benchmarks.qpcc import branch_and_bound, known_global, nasty, robot_like
from tauten.controller.qpcc import (
    Qpcc,
    QpccSettings,
    Status,
    available_backends,
    certify,
    solve_qpcc,
)
from tauten.model.numerics import Array

DESCENT = 1e-6  # slope, relative to the gradient's terms, above which a direction leads down


def solve_nasty(seeds: range) -> int:
    """Solve problems and look at what is claimed; how many are OK."""
    ok = 0
    for seed in seeds:
        problem = nasty(np.random.default_rng(seed))
        solution = solve_qpcc(problem)
        where = f"seed {seed}, {solution.status}"
        assert np.isfinite(solution.lam_a).all() and np.isfinite(solution.beta).all(), where
        if solution.status is Status.INFEASIBLE:
            assert not has_feasible_point(problem), where
        if solution.status.ok:
            ok += 1
            assert worst(solution.certificate) <= EXACT, where
            assert steepest_slope(problem, solution.lam_a, solution.beta) >= -DESCENT, where
    return ok


@pytest.mark.long
def test_claims_hold_on_nasty_problems() -> None:
    assert solve_nasty(range(100)) > 38


@pytest.mark.parametrize("share", [1e-8, 1e-10, 1e-12])
def test_a_part_at_rest_beside_one_that_moves_is_decided_as_alone(share: float) -> None:
    """Two problems in one, with no term in common; the efforts of one are a small share of the other's."""
    for seed in range(100):
        rng = np.random.default_rng(seed)
        moves, rests = random_box(rng, 1.0), random_box(rng, share)
        solution = solve_qpcc(within_box(block_diag(moves.Q, rests.Q), np.append(moves.c, rests.c)))
        assert solution.status is Status.OK, seed
        alone = np.append(solve_qpcc(moves).lam_a, solve_qpcc(rests).lam_a)
        assert solution.lam_a == pytest.approx(alone, abs=1e-10), seed


def random_box(rng: np.random.Generator, size: float) -> Qpcc:
    """Three efforts of a given size, some of them zero."""
    F = rng.normal(size=(3, 3))
    return within_box(F @ F.T + 0.1 * np.eye(3), size * rng.normal(size=3))


def within_box(Q: Array, c: Array) -> Qpcc:
    """Efforts between zero and a bound that none reaches, without contacts and limits."""
    n, none = len(c), np.zeros(0)
    return Qpcc(
        Q=Q,
        c=c,
        lb=np.zeros(n),
        ub=np.full(n, 1e4),
        G=np.zeros((0, n)),
        g_lo=none,
        g_hi=none,
        M=np.zeros((0, n)),
        m=none,
    )


@pytest.mark.slow
def test_claims_hold_on_twenty_thousand_nasty_problems() -> None:
    assert solve_nasty(range(100, 20_100)) > 8000


@pytest.mark.long
@pytest.mark.parametrize(
    ("n_a", "k", "count", "seconds", "proofs"),
    [
        *(pytest.param(n_a, 23, 40, 0.5, 20, marks=pytest.mark.slow) for n_a in (3, 9)),
        (9, 40, 20, 0.05, 0),
    ],
)
def test_cold_starts_of_robots_end_near_the_best_known(
    n_a: int, k: int, count: int, seconds: float, proofs: int
) -> None:
    """The search begins where the solution is: without a proof it may just not have looked anywhere else."""
    rng = np.random.default_rng(100 + k + n_a)
    missed = proved = 0
    for _ in range(count):
        problem = robot_like(rng, n_a, k).problem()
        solution, search = solve_qpcc(problem), branch_and_bound(problem, None, seconds)
        if np.isfinite(search.objective):
            missed += not solution.objective <= 1.01 * search.objective
            proved += search.proved
    assert missed <= 1
    assert proved >= proofs


@pytest.mark.long
def test_gaps_of_exactly_zero() -> None:
    """Half of the contacts touch at the start without a force, where many multipliers are not unique."""
    rng = np.random.default_rng(3)
    missed = proved = 0
    for i in range(24):
        n_a, k = [(3, 10), (3, 23), (9, 23)][i % 3]
        problem = robot_like(rng, n_a, k).problem()
        m = problem.m.copy()
        m[rng.permutation(k)[: k // 2]] = 0.0
        problem = replace(problem, m=m)
        solution, search = solve_qpcc(problem), branch_and_bound(problem, None, 0.1)
        if np.isfinite(search.objective):
            missed += not solution.objective <= 1.01 * search.objective
            proved += search.proved
    assert missed == 0
    assert proved >= 6  # the search begins at the solution


@pytest.mark.parametrize("solver", available_backends())
def test_the_certificate_says_what_a_library_is_good_for(solver: str) -> None:
    """No library's answer passes for better than it is, whatever becomes of the problem."""
    settings = QpccSettings(solver=solver)
    for name in ("finger_20", "three_cables_5"):
        for step in recorded(name)[::20]:
            problem = step.problem()
            solution = solve_qpcc(problem, step.start, settings)
            if solution.status.usable:
                judged = certify(problem, solution.lam_a, solution.beta)
                own = solution.certificate
                assert max(judged.primal, judged.complementarity) <= 2.0 * EXACT
                assert own.primal == pytest.approx(judged.primal, abs=EXACT)
            if solution.status.ok:
                assert worst(solution.certificate) <= EXACT


def test_limits_of_minus_infinity_leave_finite_tensions() -> None:
    known = known_global(np.random.default_rng(2), 3, 5).problem
    for crossed in (
        replace(known, ub=np.full(3, -np.inf)),
        replace(known, lb=np.full(3, np.inf), ub=np.full(3, np.inf)),
    ):
        solution = solve_qpcc(crossed)
        assert solution.status is Status.INFEASIBLE
        assert np.isfinite(solution.lam_a).all()
    free = replace(known, lb=np.full(3, -np.inf), ub=np.full(3, np.inf))
    assert np.isfinite(solve_qpcc(free).lam_a).all()


def candler_townsend() -> Qpcc:
    """MacMPEC ex9.1.3: x leads, y >= 0 minimises y1 + y2 + 2 y3 subject to A y + B x <= 1; no curvature."""
    A = np.array([[-1.0, 1.0, 1.0], [-1.0, 2.0, -0.5], [2.0, -1.0, -0.5]])
    B = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]])
    M = np.block([[np.zeros((3, 5)), A.T], [-B, -A, np.zeros((3, 3))]])
    return Qpcc(
        Q=np.zeros((8, 8)),
        c=np.array([-8.0, -4.0, 4.0, -40.0, -4.0, 0.0, 0.0, 0.0]),
        lb=np.zeros(2),
        ub=np.full(2, np.inf),
        G=np.zeros((0, 8)),
        g_lo=np.zeros(0),
        g_hi=np.zeros(0),
        M=M,
        m=np.array([1.0, 1.0, 2.0, 1.0, 1.0, 1.0]),
    )


def test_a_bilevel_program_without_curvature() -> None:
    """Optimum -29.2 at x = (0, 0.9), y = (0, 0.6, 0.4) (Candler and Townsend 1982)."""
    problem = candler_townsend()
    assert solve_qpcc(problem).status.ok  # at a local optimum
    found = branch_and_bound(problem, None, 10.0)
    assert found.objective == pytest.approx(-29.2, rel=1e-6)
    assert found.bound <= -29.2 + 1e-5


def test_rows_whose_terms_are_all_round_off_do_not_make_a_problem_infeasible() -> None:
    """Q = 0; optimum -4 at (0, 1, 0, 1.5)."""
    limits = np.array([1.0, 1.0, 0.0])
    problem = Qpcc(
        Q=np.zeros((5, 5)),
        c=np.array([4.0, -4.0, 0.0, 0.0, 0.0]),
        lb=np.zeros(4),
        ub=np.full(4, np.inf),
        G=np.array(
            [[-1.0, 1.0, 1.0, 0.0, 0.0], [-1.0, -0.5, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0, 0.0]]
        ),
        g_lo=limits,
        g_hi=limits,
        M=np.zeros((1, 5)),
        m=np.zeros(1),
    )
    solution = solve_qpcc(problem)
    assert solution.status.ok
    assert solution.objective == pytest.approx(-4.0, abs=1e-8)
    np.testing.assert_allclose(solution.lam_a, [0.0, 1.0, 0.0, 1.5], atol=1e-8)


def test_an_objective_without_a_minimum_is_never_ok() -> None:
    """A library's multipliers of a QP without a minimum are memory that was never written."""
    problem = nasty(np.random.default_rng(12944))
    for seed in range(20):
        solve_qpcc(nasty(np.random.default_rng(seed)))  # leaves other numbers in memory
        solution = solve_qpcc(problem)
        assert not solution.status.ok
        assert np.isfinite(solution.certificate.stationarity)
