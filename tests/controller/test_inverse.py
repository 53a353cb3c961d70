"""The inverse problem is (T1), term by term."""

from __future__ import annotations

import weakref
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from benchmarks.qpcc import robot_like
from tauten.controller import closed_compliance, energy_scale, inverse_problem
from tauten.controller.planning import position_names
from tauten.controller.qpcc import Qpcc, solve_qpcc
from tauten.model import cable_actuators, row_layout

N_A, K, H, EPSILON = 3, 4, 0.02, 1e-2
ROBOT = robot_like(np.random.default_rng(1), N_A, K)
W, FREE, LIMITS, TARGET = ROBOT.W, ROBOT.delta_free, ROBOT.limits, ROBOT.target
OPEN = np.zeros(K, dtype=np.bool_)
SCALE = energy_scale(W, row_layout(3, N_A), OPEN)
PULL = np.array([0.010, 0.0395, -0.0045])  # free, near the largest, near the smallest


def problem_of(epsilon: float = EPSILON) -> Qpcc:
    return inverse_problem(W, FREE, TARGET, PULL, LIMITS, H, epsilon * SCALE)


def test_the_objective_is_error_and_energy() -> None:
    rng = np.random.default_rng(2)
    problem = problem_of()
    a, e = slice(3, 3 + N_A), slice(0, 3)
    scale = np.sum(W[e, a] ** 2) / np.trace(W[a, a])
    for _ in range(5):
        lam_a, beta = rng.uniform(0.0, 5.0, N_A), rng.uniform(0.0, 5.0, K)
        delta = FREE + W @ np.concatenate([np.zeros(3), lam_a, beta])
        error = delta[e] - TARGET
        expected = 0.5 * error @ error + 0.5 * EPSILON * scale * lam_a @ W[a, a] @ lam_a
        assert problem.objective(lam_a, beta) == pytest.approx(expected, rel=1e-12)


def test_rows_are_pulls_and_gaps() -> None:
    rng = np.random.default_rng(3)
    problem = problem_of()
    lam_a, beta = rng.uniform(0.0, 5.0, N_A), rng.uniform(0.0, 5.0, K)
    z = np.concatenate([lam_a, beta])
    delta = FREE + W @ np.concatenate([np.zeros(3), z])
    position = delta[3 : 3 + N_A]
    np.testing.assert_allclose(problem.M @ z + problem.m, delta[3 + N_A :], rtol=1e-12)
    low = np.maximum(LIMITS.position_min, PULL - H * LIMITS.rate)
    high = np.minimum(LIMITS.position_max, PULL + H * LIMITS.rate)
    np.testing.assert_allclose(problem.G @ z - problem.g_lo, position - low, atol=1e-15)
    np.testing.assert_allclose(problem.g_hi - problem.G @ z, high - position, atol=1e-15)
    np.testing.assert_array_equal(problem.lb, LIMITS.effort_min)
    np.testing.assert_array_equal(problem.ub, LIMITS.effort_max)


def test_the_tighter_limit_gives_its_name() -> None:
    assert problem_of().row_names == (
        ("rate of cable 0", "rate of cable 0"),
        ("rate of cable 1", "largest pull of cable 1"),
        ("least pull of cable 2", "rate of cable 2"),
    )
    assert problem_of().bound_names[2] == "tension of cable 2"


def test_epsilon_has_no_unit() -> None:
    """The same robot measured in millimetres takes the same tensions."""
    metres = problem_of()
    millimetres = inverse_problem(
        1e3 * W,
        1e3 * FREE,
        1e3 * TARGET,
        1e3 * PULL,
        replace(
            LIMITS,
            position_min=1e3 * LIMITS.position_min,
            position_max=1e3 * LIMITS.position_max,
            rate=1e3 * LIMITS.rate,
        ),
        H,
        EPSILON * energy_scale(1e3 * W, row_layout(3, N_A), OPEN),
    )
    np.testing.assert_allclose(millimetres.Q, 1e6 * metres.Q, rtol=1e-12)
    np.testing.assert_allclose(millimetres.g_hi, 1e3 * metres.g_hi, rtol=1e-9, atol=1e-12)


@pytest.mark.long
def test_closed_contacts_stiffen_what_the_cables_move() -> None:
    """W̃_ea is the motion of the effectors when the gaps of the pushing contacts do not change."""
    pushing = np.array([True, False, True, False])
    c = 3 + N_A + np.flatnonzero(pushing)
    for column in range(N_A):
        lam = np.zeros(len(W))
        lam[3 + column] = 1.0
        lam[c] = np.linalg.solve(W[np.ix_(c, c)], -W[c, 3 + column])
        expected = (W @ lam)[:3]
        closed = closed_compliance(W, 3, N_A, pushing)
        np.testing.assert_allclose(closed[:, column], expected, rtol=1e-6)
    np.testing.assert_array_equal(closed_compliance(W, 3, N_A, OPEN), W[:3, 3 : 3 + N_A])


@pytest.mark.parametrize("kind", ["twins", "rigid", "all rigid"])
def test_contacts_without_compliance_of_their_own_are_no_trouble(kind: str) -> None:
    singular = W.copy()
    first, second = 3 + N_A, 4 + N_A
    if kind == "twins":
        singular[second], singular[:, second] = W[first], W[:, first]
        singular[second, second] = W[first, first]
    else:
        rigid = slice(first, None if kind == "all rigid" else second)
        singular[rigid], singular[:, rigid] = 0.0, 0.0
    stiff = closed_compliance(singular, 3, N_A, np.ones(K, dtype=np.bool_))
    assert np.isfinite(stiff).all()
    assert np.abs(stiff).max() <= 1.01 * np.abs(singular[:3]).max()


def test_more_weight_on_energy_takes_less_of_it() -> None:
    W_aa = W[3 : 3 + N_A, 3 : 3 + N_A]
    energies = []
    for epsilon in (1e-6, 1e-2, 1.0, 100.0):
        solution = solve_qpcc(replace(problem_of(epsilon), G=np.zeros((N_A, N_A + K))))
        energies.append(solution.lam_a @ W_aa @ solution.lam_a)
    assert all(later <= before for before, later in pairwise(energies))
    assert energies[-1] < 0.1 * energies[0]


def test_the_scale_without_coupling() -> None:
    uncoupled = np.diag([1.0, 1.0, 1.0, 1e-4, 3e-4])
    none = np.zeros(0, dtype=np.bool_)
    assert energy_scale(uncoupled, row_layout(3, 2), none) == pytest.approx(2e-4)
    assert energy_scale(np.zeros((5, 5)), row_layout(3, 2), none) == 0.0


def test_names_of_limits_keep_no_actuators_alive() -> None:
    """Locks make a set of actuators in every tick."""
    actuators = cable_actuators(("left", "right"))
    by_rate = np.array([[True, False], [False, True]])
    assert position_names(actuators.position_names, by_rate.tobytes()) == (
        ("rate of cable left", "largest pull of cable left"),
        ("least pull of cable right", "rate of cable right"),
    )
    gone = weakref.ref(actuators)
    del actuators
    assert gone() is None
