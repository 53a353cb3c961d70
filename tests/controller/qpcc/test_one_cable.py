"""One tension: the parabola over an interval is what a QP library finds, for QPs and for pieces."""

from itertools import product

import numpy as np
import pytest

from tauten.controller.qpcc import (
    UNBOUNDED,
    USABLE,
    Qp,
    QpAnswer,
    Scaled,
    Start,
    feasible_start,
    judge,
    least_violation,
    parabola,
    scale,
    solve_daqp,
    solve_piece,
    within_limit,
)
from tauten.controller.qpcc import solve as qpcc
from tauten.service.bench.qpcc import robot_like


def library(qp: Qp) -> QpAnswer:
    """The default library, under a name that takes no short cut."""
    return solve_daqp(qp)


def random_line(rng: np.random.Generator) -> Qp:
    """A QP in one variable: limits on one side, on both or on none, now and then in conflict."""
    m = int(rng.integers(0, 6))
    lower, upper = np.full(1 + m, -UNBOUNDED), np.full(1 + m, UNBOUNDED)
    middle, width = rng.normal(scale=0.5, size=1 + m), rng.uniform(0.0, 2.0, 1 + m)
    below, above = rng.random(1 + m) < 0.6, rng.random(1 + m) < 0.6
    lower[below], upper[above] = (middle - width)[below], (middle + width)[above]
    sign = rng.choice([-1.0, 1.0], size=(m, 1))
    A = sign * rng.uniform(0.1, 3.0, (m, 1))
    return Qp(np.array([[1.0]]), rng.normal(scale=2.0, size=1), A, lower, upper)


def test_a_parabola_has_the_librarys_minimum() -> None:
    rng, empty, limited = np.random.default_rng(0), 0, 0
    for _ in range(2000):
        qp = random_line(rng)
        y, multipliers = np.zeros(1), np.zeros(len(qp.lower))
        found = parabola(1.0, qp.f[0], qp.A, qp.lower, qp.upper, y, multipliers)
        answer = solve_daqp(qp)
        assert found is not answer.infeasible
        if not found:
            empty += 1
            continue
        limited += bool(multipliers.any())
        np.testing.assert_allclose(y, answer.y, atol=1e-9)
        rows = np.vstack([np.eye(1), qp.A])
        assert abs(y[0] + qp.f[0] + (multipliers @ rows)[0]) < 1e-12
        values = rows @ y
        np.testing.assert_allclose(values[multipliers > 0], qp.upper[multipliers > 0], atol=1e-12)
        np.testing.assert_allclose(values[multipliers < 0], qp.lower[multipliers < 0], atol=1e-12)
    assert empty > 100
    assert limited > 500


@pytest.mark.parametrize(("slope", "end"), [(1.0, -2.0), (-1.0, 3.0), (0.0, 0.0)])
def test_a_straight_line_ends_at_a_limit(slope: float, end: float) -> None:
    y = np.zeros(1)
    found = parabola(
        0.0, slope, np.zeros((0, 1)), np.array([-2.0]), np.array([3.0]), y, np.zeros(1)
    )
    assert found
    assert y[0] == end


def test_a_line_that_falls_for_ever_has_no_minimum() -> None:
    ends = np.array([-UNBOUNDED]), np.array([UNBOUNDED])
    assert not parabola(0.0, 1.0, np.zeros((0, 1)), *ends, np.zeros(1), np.zeros(1))


def test_pieces_of_robots_with_one_cable_are_the_librarys() -> None:
    rng, solved = np.random.default_rng(1), 0
    for _ in range(120):
        numbers, problem, _ = scale(robot_like(rng, 1, 4).problem())
        assert numbers == USABLE
        for pushes in product([False, True], repeat=4):
            piece = np.array(pushes)
            mine, theirs = (solve_piece(problem, piece, solve) for solve in (solve_daqp, library))
            assert (mine is None) == (theirs is None)
            if mine is None or theirs is None:
                continue
            solved += 1
            np.testing.assert_allclose(mine.z, theirs.z, atol=1e-8)
            np.testing.assert_allclose(mine.worth.gain, theirs.worth.gain, atol=1e-6)
    assert solved > 100


def test_no_elastic_problem_where_the_limit_is_along_the_tension(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rng, starts_outside = np.random.default_rng(4), 0

    def elastic(problem: Scaled, *_: object) -> None:
        assert not tension_within(problem)

    def tension_within(problem: Scaled) -> bool:
        """Whether a tension is seen to satisfy the limit, of many."""
        open_ = np.zeros(len(problem.Q) - 1, dtype=bool)
        pulls = []
        for a in np.linspace(problem.lb[0], problem.ub[0], 400):
            possible, _, z = feasible_start(problem, np.array([a]), open_)
            pulls += [problem.R[-1] @ z] if possible else []
        return any(problem.lo[-1] <= pull <= problem.hi[-1] for pull in pulls)

    monkeypatch.setattr(qpcc, "least_violation", elastic)
    for _ in range(250):
        robot = robot_like(rng, 1, 3)
        problem = robot.problem(pull_prev=rng.normal(scale=2e-3, size=1))
        closed = np.zeros(3, dtype=bool)
        start = Start(rng.uniform(0.0, 4.0, 1), closed)
        solution = qpcc.solve_qpcc(problem, start)
        forces = np.concatenate([start.lam_a, np.zeros(3)])
        starts_outside += solution.status.ok and not (
            problem.g_lo[0] <= (problem.G @ forces)[0] <= problem.g_hi[0]
        )
    assert starts_outside > 30


def test_a_tension_within_the_limit_is_found_along_the_contact_forces() -> None:
    rng, found_one, found_none = np.random.default_rng(2), 0, 0
    for _ in range(400):
        k = int(rng.integers(1, 7))
        robot, closed = robot_like(rng, 1, k), np.zeros(k, dtype=bool)
        _, problem, _ = scale(robot.problem(pull_prev=rng.normal(scale=2e-3, size=1)))
        tension = np.array([rng.uniform(problem.lb[0], 0.2 * problem.ub[0])])
        possible, piece, z = feasible_start(problem, tension, closed)
        pull = problem.R[2 * k] @ z
        if not possible or problem.lo[2 * k] <= pull <= problem.hi[2 * k]:
            continue
        found, _, point = within_limit(problem, z, piece)
        best = least_violation(problem, solve_daqp, 100, piece)
        assert best is not None
        worth = judge(problem, point, np.zeros(1), np.zeros(len(problem.r)))
        if not found or worth.primal > 1e-8:  # the elastic problem has no feasible point either
            assert best.worth.primal > 1e-8
            found_none += 1
            continue
        found_one += 1
        assert worth.primal < 1e-12
        assert worth.complementarity < 1e-9
    assert found_one > 50
    assert found_none > 20
