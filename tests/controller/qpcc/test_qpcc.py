"""Solutions of QPCCs against known ones, exact oracles, each other; what must not matter does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.qpcc_checks import EXACT, assert_solves, recorded, staying, violation, worst

from benchmarks.qpcc import (
    branch_and_bound,
    enumerate_pieces,
    known_global,
    known_stationary,
    robot_like,
    scip_optimum,
)
from tauten.controller.qpcc import (
    Qpcc,
    QpccSettings,
    Start,
    available_backends,
    certify,
    solve_qpcc,
)
from tauten.model.numerics import Bools

SEARCH = 300.0  # s; ends long before where it is proved, also where kernels are compiled beside other work
ONE_START = QpccSettings(second_start="never")


def finger_that_closes(target: float, gap: float = 1.0) -> Qpcc:
    """One tension, one contact, by hand: tip x = a - 0.8 β, gap w = gap - a + β.

    Open while a < gap, where x = a; then β = a - gap and x = a - 0.8 (a - gap).
    """
    e = np.array([1.0, -0.8])
    return Qpcc(
        Q=np.outer(e, e),
        c=-target * e,
        lb=np.zeros(1),
        ub=np.array([10.0]),
        G=np.zeros((0, 2)),
        g_lo=np.zeros(0),
        g_hi=np.zeros(0),
        M=np.array([[-1.0, 1.0]]),
        m=np.array([gap]),
        constant=0.5 * target**2,
    )


@pytest.mark.parametrize(
    ("target", "effort", "force"),
    [(0.5, 0.5, 0.0), (1.0, 1.0, 0.0), (1.4, 3.0, 2.0), (5.0, 10.0, 9.0), (-1.0, 0.0, 0.0)],
)
def test_a_finger_by_hand(target: float, effort: float, force: float) -> None:
    problem = finger_that_closes(target)
    for warm in (None, np.array([True]), np.array([False])):
        solution = solve_qpcc(problem, warm)
        assert_solves(problem, solution)
        np.testing.assert_allclose(solution.lam_a, [effort], atol=1e-9)
        np.testing.assert_allclose(solution.beta, [force], atol=1e-9)
        tip = effort - 0.8 * force
        assert solution.objective == pytest.approx(0.5 * (tip - target) ** 2, abs=1e-12)


def test_crossing_a_kink_takes_two_pieces() -> None:
    problem = finger_that_closes(1.4)
    from_open = solve_qpcc(problem, settings=ONE_START)
    assert from_open.pivots == 2
    assert from_open.piece.tolist() == [True]
    assert solve_qpcc(problem, from_open).pivots == 1


@pytest.mark.parametrize("degenerate", [0, 2, 4])
def test_known_global_optima_are_found(degenerate: int) -> None:
    rng = np.random.default_rng(10 + degenerate)
    for n_a, k in ((1, 4), (3, 8), (9, 23)) * 5:
        known = known_global(rng, n_a, k, degenerate)
        lowest = known.problem.objective(known.lam_a, known.beta)
        solution = solve_qpcc(known.problem)
        assert_solves(known.problem, solution)
        assert solution.objective == pytest.approx(lowest, rel=1e-7)


@pytest.mark.parametrize("degenerate", [0, 3])
def test_a_known_stationary_point_is_recognised_and_kept(degenerate: int) -> None:
    rng = np.random.default_rng(20 + degenerate)
    for n_a, k in ((1, 4), (3, 8), (9, 23)) * 5:
        known = known_stationary(rng, n_a, k, degenerate)
        assert worst(certify(known.problem, known.lam_a, known.beta)) <= EXACT
        start = Start(known.lam_a, known.beta > 0.0)
        solution = solve_qpcc(known.problem, start)
        assert_solves(known.problem, solution)
        held = known.problem.objective(known.lam_a, known.beta)
        assert solution.objective <= held + 1e-9 * abs(held)


def test_a_point_beside_a_stationary_one_is_not_certified() -> None:
    known = known_stationary(np.random.default_rng(3), 3, 8)
    moved = certify(known.problem, known.lam_a + 1e-3, known.beta)
    assert worst(moved) > 1e-5
    swapped = certify(known.problem, known.lam_a, known.beta[::-1].copy())
    assert max(swapped.primal, swapped.complementarity) > 1e-5


def test_small_problems_against_all_pieces() -> None:
    rng = np.random.default_rng(5)
    found, total = 0, 0
    for i in range(60):
        n_a, k = int(rng.integers(1, 4)), int(rng.integers(1, 7))
        known = known_stationary(rng, n_a, k).problem
        problem = robot_like(rng, n_a, k).problem() if i % 2 else known
        lowest, _ = enumerate_pieces(problem)
        solution, search = solve_qpcc(problem), branch_and_bound(problem, None, SEARCH)
        assert search.proved
        if not np.isfinite(lowest):
            assert not solution.status.usable
            assert search.bound == np.inf
            continue
        margin = 1e-7 * max(abs(lowest), problem.constant)
        assert_solves(problem, solution)
        assert search.objective == pytest.approx(lowest, abs=margin)
        assert search.bound <= lowest + margin
        assert solution.objective >= lowest - margin
        found += solution.objective <= lowest + margin
        total += 1
    assert total > 40
    assert found >= 0.9 * total


@pytest.mark.parametrize("k", [10, 13, 15])
def test_larger_problems_against_scip(k: int) -> None:
    rng, compared = np.random.default_rng(k), 0
    for _ in range(2):
        problem = robot_like(rng, 3, k).problem()
        objective, bound = scip_optimum(problem)
        solution = solve_qpcc(problem)
        if not np.isfinite(objective):
            assert not solution.status.usable
            continue
        compared += 1
        margin = 1e-5 * abs(objective)
        assert solution.objective == pytest.approx(objective, abs=margin)
        assert bound <= solution.objective + margin
    assert compared


def test_the_second_start_never_loses() -> None:
    rng = np.random.default_rng(8)
    improved = 0
    for _ in range(40):
        known = known_stationary(rng, 3, 8)
        start = Start(known.lam_a, known.beta > 0.0)
        first = solve_qpcc(known.problem, start)
        second = solve_qpcc(known.problem, start, QpccSettings(second_start="always"))
        assert second.objective <= first.objective + 1e-9 * abs(first.objective)
        improved += second.objective < first.objective - 1e-3 * abs(first.objective)
    assert improved >= 5  # these have local optima, else nothing was tested


def test_a_warm_start_takes_no_second_one() -> None:
    problem = robot_like(np.random.default_rng(19), 9, 23).problem()
    settings = [QpccSettings(second_start=choice) for choice in ("cold", "always", "never")]  # type: ignore[arg-type]
    start = Start(np.zeros(9), np.zeros(23, dtype=np.bool_))
    cold, always, never = (solve_qpcc(problem, start, one).pivots for one in settings)
    assert cold == never < always


def test_never_worse_than_staying() -> None:
    rng = np.random.default_rng(12)
    compared = 0
    for n_a, k in ((1, 5), (3, 10), (9, 23)) * 20:
        problem = robot_like(rng, n_a, k).problem()
        lam_a, piece = rng.uniform(0.0, 3.0, n_a), np.zeros(k, dtype=np.bool_)
        objective, outside = staying(problem, lam_a)
        solution = solve_qpcc(problem, Start(lam_a, piece))
        if outside > 1e-12:
            continue
        compared += 1
        assert solution.status.usable
        assert solution.objective <= objective * (1.0 + 1e-9)
    assert compared > 15


@pytest.mark.parametrize("n_a, k", [(1, 5), (3, 10), (9, 23)])
def test_an_exact_start_needs_one_piece(n_a: int, k: int) -> None:
    rng, compared = np.random.default_rng(13), 0
    for _ in range(10):
        problem = robot_like(rng, n_a, k).problem()
        first = solve_qpcc(problem)
        if not first.status.ok:
            continue
        compared += 1
        again = solve_qpcc(problem, first)
        assert again.pivots == 1
        assert again.objective == pytest.approx(first.objective, rel=1e-9)
        np.testing.assert_allclose(again.beta, first.beta, atol=1e-9)
    assert compared > 5


WRONG_STARTS = [
    np.zeros(99, dtype=np.bool_),
    Start(np.full(3, np.nan), np.zeros(8, dtype=np.bool_)),
    Start(np.full(3, 1e300), np.ones(8, dtype=np.bool_)),
    Start(np.full(3, -1.0), np.ones(2, dtype=np.bool_)),
    Start(np.zeros(7), np.zeros(0, dtype=np.bool_)),
]


@pytest.mark.parametrize("warm", WRONG_STARTS, ids=range(len(WRONG_STARTS)))
def test_starts_that_do_not_fit_do_no_harm(warm: Start | Bools) -> None:
    known = known_global(np.random.default_rng(14), 3, 8)
    assert_solves(known.problem, solve_qpcc(known.problem, warm))


@pytest.mark.parametrize("name", available_backends())
def test_back_ends_agree_or_their_certificate_says_not(name: str) -> None:
    settings, agree = QpccSettings(solver=name), 0
    steps = [recorded("finger_5")[i] for i in (0, 30, 60, 90)]
    steps += [recorded("three_cables_5")[i] for i in (10, 50)]
    for step in steps:
        problem = step.problem()
        reference = solve_qpcc(problem, step.start)
        solution = solve_qpcc(problem, step.start, settings)
        if not solution.status.ok:
            assert not solution.status.usable or worst(solution.certificate) > EXACT
            continue
        agree += 1
        assert_solves(problem, solution)
        assert solution.objective == pytest.approx(reference.objective, rel=1e-6)
        np.testing.assert_allclose(solution.lam_a, reference.lam_a, atol=1e-5)
    assert agree >= 1


def test_an_unknown_back_end_raises() -> None:
    with pytest.raises(ValueError, match="not installed"):
        solve_qpcc(finger_that_closes(1.0), settings=QpccSettings(solver="none such"))


def test_arrays_that_do_not_fit_raise() -> None:
    with pytest.raises(ValueError, match="do not fit 1 bounds, 1 complementarity rows"):
        replace(finger_that_closes(1.0), Q=np.eye(3))


@pytest.mark.parametrize(("n_a", "k", "p"), [(0, 0, 0), (2, 0, 0), (0, 3, 0), (2, 0, 1), (2, 3, 0)])
def test_empty_parts(n_a: int, k: int, p: int) -> None:
    rng = np.random.default_rng(15)
    n = n_a + k
    problem = Qpcc(
        Q=np.eye(n),
        c=rng.normal(size=n),
        lb=np.full(n_a, -1.0),
        ub=np.full(n_a, 1.0),
        G=np.ones((p, n)),
        g_lo=np.full(p, -np.inf),
        g_hi=np.full(p, 0.5),
        M=np.hstack([rng.normal(size=(k, n_a)), np.eye(k)]),
        m=rng.normal(size=k),
    )
    solution = solve_qpcc(problem)
    assert_solves(problem, solution)
    assert violation(problem, solution.lam_a, solution.beta) <= 1e-9


def test_units_do_not_matter() -> None:
    """In newton and millimetres or kilonewton and metres, with another unit of the objective."""
    rng = np.random.default_rng(16)
    for _ in range(10):
        problem = robot_like(rng, 3, 10).problem()
        first = solve_qpcc(problem)
        for force, length in ((1e3, 1e-3), (1e-6, 1e6), (3.0, 7.0)):
            cost = length**2
            other = Qpcc(
                Q=problem.Q * cost / force**2,
                c=problem.c * cost / force,
                lb=problem.lb * force,
                ub=problem.ub * force,
                G=problem.G * length / force,
                g_lo=problem.g_lo * length,
                g_hi=problem.g_hi * length,
                M=problem.M * length / force,
                m=problem.m * length,
                constant=problem.constant * cost,
            )
            second = solve_qpcc(other)
            assert second.status == first.status
            if first.status.ok:
                np.testing.assert_array_equal(second.piece, first.piece)
                np.testing.assert_allclose(second.lam_a, first.lam_a * force, rtol=1e-6)
                assert second.objective == pytest.approx(first.objective * cost, rel=1e-6)


def test_the_order_of_modes_does_not_matter_to_the_optimum() -> None:
    rng = np.random.default_rng(17)
    for _ in range(10):
        problem = known_stationary(rng, 2, 6).problem
        order = rng.permutation(6)
        z = np.concatenate([np.arange(2), 2 + order])
        other = replace(
            problem,
            Q=problem.Q[np.ix_(z, z)],
            c=problem.c[z],
            G=problem.G[:, z],
            M=problem.M[order][:, z],
            m=problem.m[order],
        )
        first, second = (branch_and_bound(one, None, SEARCH) for one in (problem, other))
        assert second.objective == pytest.approx(first.objective, rel=1e-6)


def test_problems_are_not_changed_and_answers_repeat() -> None:
    problem = robot_like(np.random.default_rng(18), 3, 10).problem()
    before = [array.copy() for array in problem.arrays]
    first, second = solve_qpcc(problem), solve_qpcc(problem)
    for array, old in zip(problem.arrays, before, strict=True):
        np.testing.assert_array_equal(array, old)
    np.testing.assert_array_equal(first.lam_a, second.lam_a)
    np.testing.assert_array_equal(first.beta, second.beta)
