"""Degenerate QPCCs: dependent and duplicate modes, no coupling, limits that leave no room."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference.linear_programs import steepest_slope
from support.qpcc_checks import EXACT, assert_solves, violation, worst

from benchmarks.qpcc import RobotLike, degenerate, enumerate_pieces, robot_like
from tauten.controller.qpcc import Qpcc, QpccSettings, Solution, Start, Status, solve_qpcc
from tauten.model.numerics import Array


@pytest.mark.long
@pytest.mark.parametrize(("n_a", "k"), [(1, 5), (3, 10), (9, 23)])
def test_degenerate_families_end_ok_or_say_why_not(n_a: int, k: int) -> None:
    rng = np.random.default_rng(n_a)
    ok = 0
    for _ in range(60):
        problem = degenerate(rng, n_a, k)
        solution = solve_qpcc(problem)
        if solution.status.usable:
            assert violation(problem, solution.lam_a, solution.beta) <= 1e-8
        if solution.status.ok:
            assert worst(solution.certificate) <= EXACT
            ok += 1
    assert ok >= 30  # limits almost equal leave many without a feasible point


@pytest.mark.long
def test_degenerate_small_problems_against_all_pieces() -> None:
    rng = np.random.default_rng(2)
    feasible = lowest_found = 0
    for _ in range(120):
        problem = degenerate(rng, int(rng.integers(1, 4)), int(rng.integers(2, 7)))
        lowest, _ = enumerate_pieces(problem)
        solution = solve_qpcc(problem)
        assert solution.status.usable == np.isfinite(lowest)
        if solution.status.usable:
            feasible += 1
            lowest_found += solution.objective <= lowest + 1e-6 * abs(lowest) + 1e-15
    assert feasible > 60
    assert lowest_found >= 0.98 * feasible


def corner(slopes: tuple[float, float], target: float) -> Qpcc:
    """One tension held at the kink of two contacts that close together, w_i = -slope_i a + β_i.

    The tip is x = a - 2 β_0 - 2 β_1: pulling further than the kink turns it back.
    """
    e = np.array([1.0, -2.0, -2.0])
    return Qpcc(
        Q=np.outer(e, e),
        c=-target * e,
        lb=np.array([-1.0]),
        ub=np.array([1.0]),
        G=np.zeros((0, 3)),
        g_lo=np.zeros(0),
        g_hi=np.zeros(0),
        M=np.array([[-slopes[0], 1.0, 0.0], [-slopes[1], 0.0, 1.0]]),
        m=np.zeros(2),
    )


@pytest.mark.parametrize("slopes", [(1.0, 1.0), (1.0, 0.5), (0.2, 2.0)])
@pytest.mark.parametrize("warm", [(False, False), (True, False), (False, True), (True, True)])
def test_the_tip_of_a_kink_is_left_to_the_right_side_or_not_at_all(
    slopes: tuple[float, float], warm: tuple[bool, bool]
) -> None:
    # with both pushing x = a (1 - 2 (s0 + s1)) < 0 for a > 0, so that target 0.1 cannot be reached:
    # a = 0 is the optimum over a >= 0, and over a <= 0 (open, x = a) too; -0.1 can, from either side
    piece = np.array(warm)
    above = solve_qpcc(corner(slopes, 0.1), piece)
    assert above.status.ok
    np.testing.assert_allclose(above.lam_a, [0.0], atol=1e-9)
    below = solve_qpcc(corner(slopes, -0.1), piece)
    assert_solves(corner(slopes, -0.1), below)
    assert below.objective == pytest.approx(-0.5 * 0.1**2, rel=1e-9)


def test_twins_share_a_force() -> None:
    problem = robot_like(np.random.default_rng(3), 2, 4).problem()
    n, twin = 6, np.r_[0:6, 5]
    double = replace(
        problem,
        Q=problem.Q[np.ix_(twin, twin)],
        c=problem.c[twin],
        G=problem.G[:, twin],
        M=problem.M[np.r_[0:4, 3]][:, twin],
        m=problem.m[np.r_[0:4, 3]],
    )
    single, both = solve_qpcc(problem), solve_qpcc(double)
    assert_solves(double, both)
    assert both.objective == pytest.approx(single.objective, rel=1e-9)
    np.testing.assert_allclose(both.lam_a, single.lam_a, atol=1e-8)
    assert both.beta[n - 3] + both.beta[n - 2] == pytest.approx(single.beta[3], abs=1e-8)


def test_an_effector_that_feels_nothing_costs_nothing() -> None:
    problem = robot_like(np.random.default_rng(4), 3, 10).problem()
    numb = replace(problem, Q=np.zeros((13, 13)), c=np.zeros(13))
    solution = solve_qpcc(numb)
    assert_solves(numb, solution)
    assert solution.objective == problem.constant


def test_tensions_that_cannot_change() -> None:
    problem = robot_like(np.random.default_rng(5), 3, 10).problem()
    fixed = np.array([1.0, 0.0, 2.0])
    held = replace(
        problem,
        lb=fixed,
        ub=fixed,
        g_lo=np.full(3, -np.inf),
        g_hi=np.full(3, np.inf),
    )
    solution = solve_qpcc(held)
    assert solution.status is Status.OK
    np.testing.assert_array_equal(solution.lam_a, fixed)
    assert violation(held, solution.lam_a, solution.beta) <= 1e-12


@pytest.mark.parametrize("apart", [1e-6, 1e-5, 1e-4])
@pytest.mark.parametrize(("n_a", "k"), [(1, 0), (3, 0), (3, 5), (7, 10)])
def test_a_cable_beside_another_one_does_no_harm(n_a: int, k: int, apart: float) -> None:
    """Two cables do no worse than one, and no better than one that may pull twice as hard."""
    compared, missed, margin = 0, 0, 1e-3 + 30.0 * apart
    for seed in range(25):
        rng = np.random.default_rng(seed)
        one = robot_like(rng, n_a, k)
        one = replace(one, drift=np.zeros_like(one.drift))
        wider = replace(one.limits, effort_max=np.r_[40.0, one.limits.effort_max[1:]])
        robots = (
            replace(one, limits=wider),
            with_twin(one, apart * rng.normal(size=len(one.W))),
            one,
        )
        strong, two, single = (solved_from_rest(robot) for robot in robots)
        if single.status is Status.OK:
            compared += 1
            missed += two.status is not Status.OK
            if two.status is Status.OK:
                assert two.objective <= single.objective * (1.0 + margin), seed
                assert two.objective >= strong.objective * (1.0 - margin), seed
    assert compared > 20
    assert missed <= (apart < 1e-5)  # at 1e-6, of some hundred a few are not solved


def test_contacts_that_touch_without_a_force_are_decided() -> None:
    """Multipliers are not unique there: each of the pairs may push or open, and none of it may lead down."""
    decided = 0
    for seed in range(1, 81, 2):
        rng = np.random.default_rng(seed)
        n_a, k = int(rng.integers(1, 4)), int(rng.integers(2, 6))
        problem = robot_like(rng, n_a, k).problem()
        problem = replace(problem, m=np.where(rng.random(k) < 0.7, 0.0, problem.m))
        solution = solve_qpcc(problem, Start(np.zeros(n_a), rng.random(k) < 0.5))
        if not solution.status.usable:
            continue
        decided += 1
        assert solution.status is Status.OK, seed
        assert steepest_slope(problem, solution.lam_a, solution.beta) >= -1e-6, seed
    assert decided > 30


def with_twin(robot: RobotLike, apart: Array) -> RobotLike:
    """The robot with one more cable, whose row is that of the first one and a little (m,) of all."""
    rows = np.r_[0:4, 3 : len(robot.W)]
    J, cables = np.eye(len(robot.W))[rows], np.r_[0, 0 : len(robot.limits.rate)]
    J[3] += apart
    W, delta_free, still = J @ robot.W @ J.T, J @ robot.delta_free, np.zeros((len(J), len(J)))
    limits = robot.limits.at(cables)
    return replace(robot, W=W, delta_free=delta_free, limits=limits, drift=still)


def solved_from_rest(robot: RobotLike) -> Solution:
    """The solution as in a control loop that starts without tension."""
    problem = robot.problem()
    start = Start(np.zeros(len(problem.lb)), np.zeros(len(problem.m), np.bool_))
    return solve_qpcc(problem, start, QpccSettings(second_start="never"))
