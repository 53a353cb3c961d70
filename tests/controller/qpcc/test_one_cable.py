"""One tension: the parabola over an interval is what a QP library finds, for QPs and for pieces."""

from itertools import product

import numpy as np
import pytest

from benchmarks.qpcc import robot_like
from tauten.controller.qpcc import (
    UNBOUNDED,
    USABLE,
    Qp,
    QpAnswer,
    parabola,
    scale,
    solve_daqp,
    solve_piece,
)


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
            np.testing.assert_allclose(mine.residuals.gain, theirs.residuals.gain, atol=1e-6)
    assert solved > 100
