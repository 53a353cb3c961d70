"""How a solve ends: every status, what comes back with it, which limits are named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference.linear_programs import has_feasible_point
from support.qpcc_checks import EXACT, RECORDED, assert_solves, recorded, violation, worst

from benchmarks.qpcc import known_stationary, nonsense, robot_like, scip_optimum
from tauten.controller.qpcc import (
    Qpcc,
    QpccSettings,
    Solution,
    Start,
    Status,
    solve_qpcc,
    solve_relaxed,
)


def two_cables(**changes: object) -> Qpcc:
    """Two tensions, one limited sum, one contact that closes at a0 = 1: w = 1 - a0 + β."""
    problem = Qpcc(
        Q=np.diag([1.0, 1.0, 0.1]),
        c=np.array([-3.0, -1.0, 0.0]),
        lb=np.zeros(2),
        ub=np.full(2, 5.0),
        G=np.array([[1.0, 1.0, 0.0]]),
        g_lo=np.array([-np.inf]),
        g_hi=np.array([10.0]),
        M=np.array([[-1.0, 0.0, 1.0]]),
        m=np.array([1.0]),
        bound_names=("tension 0", "tension 1"),
        row_names=(("pull low", "pull high"),),
    )
    return replace(problem, **changes)  # type: ignore[arg-type]


def test_ok() -> None:
    assert_solves(two_cables(), solve_qpcc(two_cables()))


@pytest.mark.parametrize("field", ["Q", "c", "lb", "ub", "G", "g_lo", "g_hi", "M", "m"])
def test_a_nan_anywhere_is_not_finite(field: str) -> None:
    array = getattr(two_cables(), field).copy()
    array.flat[0] = np.nan
    solution = solve_qpcc(two_cables(**{field: array}), Start(np.ones(2), np.array([False])))
    assert solution.status is Status.NOT_FINITE
    assert not solution.status.usable
    assert solution.lam_a.tolist() == [1.0, 1.0]  # where it was asked to start


@pytest.mark.parametrize("field", ["Q", "c", "G", "M", "m"])
@pytest.mark.parametrize("value", [np.inf, -np.inf])
def test_infinity_outside_the_limits_is_not_finite(field: str, value: float) -> None:
    array = getattr(two_cables(), field).copy()
    array.flat[0] = value
    assert solve_qpcc(two_cables(**{field: array})).status is Status.NOT_FINITE


@pytest.mark.parametrize("field", ["Q", "c", "lb", "ub", "G", "g_lo", "g_hi", "M", "m"])
@pytest.mark.parametrize("value", [1e305, -1e305, 1e-305])
def test_the_ends_of_the_number_range(field: str, value: float) -> None:
    array = getattr(two_cables(), field).copy()
    array.flat[0] = value
    solution = solve_qpcc(two_cables(**{field: array}))
    assert np.isfinite(solution.lam_a).all()
    assert np.isfinite(solution.beta).all()
    if solution.status.ok:
        assert worst(solution.certificate) <= EXACT


def test_infinite_limits_are_none() -> None:
    free = two_cables(lb=np.full(2, -np.inf), ub=np.full(2, np.inf), g_hi=np.array([np.inf]))
    solution = solve_qpcc(free)
    assert_solves(free, solution)
    # min (a0 - 3)²/2 + 0.05 (a0 - 1)²: a0 = 3.1 / 1.1
    np.testing.assert_allclose(solution.lam_a, [3.1 / 1.1, 1.0], rtol=1e-9)


def test_crossed_bounds_are_named() -> None:
    solution = solve_qpcc(two_cables(lb=np.array([0.0, 6.0])))
    assert solution.status is Status.INFEASIBLE
    assert solution.conflict == ("tension 1",)


def test_crossed_limits_are_named() -> None:
    solution = solve_qpcc(two_cables(g_lo=np.array([11.0])))
    assert solution.status is Status.INFEASIBLE
    assert set(solution.conflict) == {"pull low", "pull high"}


def test_limits_in_conflict_are_named_and_the_least_violation_comes_back() -> None:
    problem = two_cables(g_lo=np.array([12.0]), g_hi=np.array([20.0]))
    solution = solve_qpcc(problem)
    assert solution.status is Status.INFEASIBLE
    assert set(solution.conflict) == {"pull low", "tension 0", "tension 1"}
    np.testing.assert_allclose(solution.lam_a, [5.0, 5.0], rtol=1e-6)
    assert violation(problem, solution.lam_a, solution.beta) == pytest.approx(2.0, rel=1e-6)


def test_names_have_a_default() -> None:
    problem = two_cables(g_lo=np.array([12.0]), g_hi=np.array([20.0]), bound_names=(), row_names=())
    assert set(solve_qpcc(problem).conflict) == {"row 0", "bound 0", "bound 1"}


def test_rows_that_contradict_each_other() -> None:
    problem = two_cables(
        G=np.array([[1.0, 1.0, 0.0], [2.0, 2.0, 0.0]]),
        g_lo=np.array([3.0, -np.inf]),
        g_hi=np.array([np.inf, 2.0]),
        row_names=(("sum low", "sum high"), ("double low", "double high")),
    )
    solution = solve_qpcc(problem)
    assert solution.status is Status.INFEASIBLE
    assert set(solution.conflict) == {"sum low", "double high"}


def test_gaps_that_no_force_opens() -> None:
    # w = -1 + 0 β: no contact force can open it
    problem = two_cables(M=np.zeros((1, 3)), m=np.array([-1.0]))
    solution = solve_qpcc(problem)
    assert solution.status is Status.INFEASIBLE
    assert solution.conflict == ("complementarity",)
    assert np.isfinite(solution.lam_a).all()


def test_a_pivot_limit_returns_a_feasible_point() -> None:
    rng = np.random.default_rng(4)
    cut_short = 0
    for _ in range(30):
        problem = robot_like(rng, 3, 10).problem()
        whole = solve_qpcc(problem, settings=QpccSettings(second_start="never"))
        one = solve_qpcc(problem, settings=QpccSettings(max_pivots=1))
        assert one.pivots <= 1
        if whole.pivots == 1 or not one.status.usable:
            continue
        assert one.status in (Status.MAX_PIVOTS, Status.OK)
        assert max(one.certificate.primal, one.certificate.complementarity) <= EXACT
        assert one.objective >= whole.objective - 1e-9 * abs(whole.objective)
        cut_short += one.status is Status.MAX_PIVOTS
    assert cut_short >= 5


def test_no_pivots_at_all_leaves_the_start() -> None:
    settings = QpccSettings(max_pivots=0)
    solution = solve_qpcc(two_cables(), Start(np.array([2.0, 1.0]), np.array([False])), settings)
    assert solution.status is Status.MAX_PIVOTS
    np.testing.assert_allclose(solution.lam_a, [2.0, 1.0])
    np.testing.assert_allclose(solution.beta, [1.0])


def test_an_objective_without_a_minimum_is_not_ok() -> None:
    problem = two_cables(
        Q=np.diag([1.0, 0.0, 0.1]),
        G=np.zeros((0, 3)),
        g_lo=np.zeros(0),
        g_hi=np.zeros(0),
        row_names=(),
        ub=np.array([5.0, np.inf]),
    )
    solution = solve_qpcc(problem)
    assert not solution.status.ok
    assert np.isfinite(solution.lam_a).all()


@pytest.mark.parametrize("count", [60, pytest.param(300, marks=pytest.mark.slow)])
def test_infeasible_means_that_all_pieces_are_empty(count: int) -> None:
    rng = np.random.default_rng(6)
    empty = 0
    for _ in range(count):
        problem = nonsense(rng, decades=0.5)
        solution = solve_qpcc(problem)
        if solution.status is Status.INFEASIBLE:
            assert not has_feasible_point(problem)
            empty += 1
    assert empty > count // 6


@pytest.mark.long
def test_scip_finds_nothing_either_where_recorded_problems_are_made_infeasible() -> None:
    """Cables that are to let out more than the robot takes up: tensions would have to be negative."""
    empty = 0
    for name in RECORDED:
        for step in [step for step in recorded(name) if step.n_c <= 20][::16]:
            problem = step.problem()
            slack = replace(problem, g_lo=problem.g_lo - 2e-3, g_hi=problem.g_lo - 1e-3)
            solution = solve_qpcc(slack, step.start)
            if solution.status is Status.INFEASIBLE:
                empty += 1
                assert scip_optimum(slack, seconds=2.0)[0] == np.inf
                assert solution.conflict
    assert empty >= 5


def test_tensions_at_an_infeasible_problem_stay_within_their_bounds() -> None:
    rng = np.random.default_rng(7)
    seen = 0
    for _ in range(60):
        problem = robot_like(rng, 3, 10).problem()
        far = replace(problem, g_lo=problem.g_hi + 0.1, g_hi=problem.g_hi + 0.2)
        solution = solve_qpcc(far)
        if solution.status is Status.INFEASIBLE:
            seen += 1
            assert np.all((solution.lam_a >= far.lb) & (solution.lam_a <= far.ub))
            assert solution.conflict
    assert seen > 50


def test_a_degenerate_start_of_a_stationary_point_keeps_it() -> None:
    known = known_stationary(np.random.default_rng(9), 3, 6, degenerate=6)
    for piece in (np.zeros(6, dtype=np.bool_), np.ones(6, dtype=np.bool_)):
        solution = solve_qpcc(known.problem, Start(known.lam_a, piece))
        assert_solves(known.problem, solution)


@pytest.mark.parametrize(
    ("reached", "gives_way"), [((0.5, 0.5), False), ((0.5, 2.0), True), ((1.0, 2.0), False)]
)
def test_a_smallest_force_gives_way_where_a_largest_one_is_exceeded_too(
    reached: tuple[float, float], gives_way: bool
) -> None:
    """Of the first tension the smallest is 1 N, of the second the largest; one that is missed alone is kept.

    What cannot be met is then relaxed by as little as the nearest point misses it.
    """
    G, limits = np.eye(2, 3), (np.array([1.0, -np.inf]), np.array([np.inf, 1.0]))
    problem = two_cables(G=G, g_lo=limits[0], g_hi=limits[1], row_names=())
    nearest = solve_qpcc(two_cables())
    nearest = replace(nearest, lam_a=np.array(reached), status=Status.INFEASIBLE)
    asked = list[Qpcc]()

    def solve(posed: Qpcc, start: Solution | None) -> Solution:
        asked.append(posed)
        return replace(nearest, status=Status.OK)

    solve_relaxed(problem, nearest, 0, solve, (Status.INFEASIBLE,))
    (posed,) = asked
    assert np.isfinite(posed.Q).all() and np.isfinite(posed.c).all()
    if gives_way:
        assert posed.g_lo.tolist() == [-np.inf, -np.inf] and posed.g_hi.tolist() == [np.inf, 1.0]
        assert posed.Q[0, 0] > problem.Q[0, 0]
    else:
        assert posed.g_lo[0] == pytest.approx(min(reached[0], 1.0))
        assert posed.g_hi[1] == pytest.approx(max(reached[1], 1.0))
        np.testing.assert_array_equal(posed.Q, problem.Q)


@pytest.mark.parametrize("sum_low", [False, True])
def test_limits_that_contradict_each_other_are_relaxed_by_as_little_as_possible(
    sum_low: bool,
) -> None:
    """The target asks for the first tension; the smallest second one is 2 N.

    Of the sum the largest is 1 N, and the smallest force gives way to it. Or its smallest is 12 N, where 10 N
    are possible, and it gives way itself.
    """
    least, most = (12.0, np.inf) if sum_low else (-np.inf, 1.0)
    low, high = np.array([2.0, least]), np.array([np.inf, most])
    names = (("second", "second"), ("sum", "sum"))
    G = np.array([[0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
    problem = two_cables(G=G, g_lo=low, g_hi=high, row_names=names)

    nearest = solve_qpcc(problem)
    assert nearest.status is Status.INFEASIBLE
    _, found = solve_relaxed(problem, nearest, 0, solve_qpcc, (Status.INFEASIBLE,))
    assert found.status is Status.RELAXED
    assert found.conflict == nearest.conflict
    assert found.lam_a == pytest.approx([5.0, 5.0] if sum_low else [0.0, 1.0], abs=0.02)
    assert found.lam_a.sum() >= 10.0 - 1e-6 if sum_low else found.lam_a.sum() <= 1.0 + 1e-8
