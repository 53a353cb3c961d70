"""The inverse problem is (T1), term by term."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tauten.controller import energy_scale, inverse_problem, shut
from tauten.controller.qpcc import Qpcc, solve_qpcc
from tauten.service.bench.qpcc import robot_like

N_A, K, H, EPSILON = 3, 4, 0.02, 1e-2
ROBOT = robot_like(np.random.default_rng(1), N_A, K)
RESPONSE, LIMITS, TARGET = ROBOT.response, ROBOT.limits, ROBOT.target
PULL = np.array([0.010, 0.0395, -0.0045])  # free, near the largest, near the smallest


def problem_of(epsilon: float = EPSILON) -> Qpcc:
    return inverse_problem(RESPONSE, TARGET, LIMITS, PULL, H, epsilon)


def test_the_objective_is_error_and_energy() -> None:
    rng = np.random.default_rng(2)
    problem, W = problem_of(), RESPONSE.W
    a, e = slice(3, 3 + N_A), slice(0, 3)
    scale = np.sum(W[e, a] ** 2) / np.trace(W[a, a])
    for _ in range(5):
        lam_a, beta = rng.uniform(0.0, 5.0, N_A), rng.uniform(0.0, 5.0, K)
        delta = RESPONSE.delta_free + W @ np.concatenate([np.zeros(3), lam_a, beta])
        error = delta[e] - TARGET
        expected = 0.5 * error @ error + 0.5 * EPSILON * scale * lam_a @ W[a, a] @ lam_a
        assert problem.objective(lam_a, beta) == pytest.approx(expected, rel=1e-12)


def test_rows_are_pulls_and_gaps() -> None:
    rng = np.random.default_rng(3)
    problem = problem_of()
    lam_a, beta = rng.uniform(0.0, 5.0, N_A), rng.uniform(0.0, 5.0, K)
    z = np.concatenate([lam_a, beta])
    delta = RESPONSE.delta_free + RESPONSE.W @ np.concatenate([np.zeros(3), z])
    pull = delta[3 : 3 + N_A]
    np.testing.assert_allclose(problem.M @ z + problem.m, delta[3 + N_A :], rtol=1e-12)
    low = np.maximum(LIMITS.pull_min, PULL - H * LIMITS.rate)
    high = np.minimum(LIMITS.pull_max, PULL + H * LIMITS.rate)
    np.testing.assert_allclose(problem.G @ z - problem.g_lo, pull - low, atol=1e-15)
    np.testing.assert_allclose(problem.g_hi - problem.G @ z, high - pull, atol=1e-15)
    np.testing.assert_array_equal(problem.lb, LIMITS.tension_min)
    np.testing.assert_array_equal(problem.ub, LIMITS.tension_max)


def test_the_tighter_limit_gives_its_name() -> None:
    assert problem_of().row_names == (
        ("rate of cable 0", "rate of cable 0"),
        ("rate of cable 1", "pull_max of cable 1"),
        ("pull_min of cable 2", "rate of cable 2"),
    )
    assert problem_of().bound_names[2] == "tension of cable 2"


def test_epsilon_has_no_unit() -> None:
    """The same robot measured in millimetres takes the same tensions."""
    metres = problem_of()
    millimetres = inverse_problem(
        replace(RESPONSE, W=1e3 * RESPONSE.W, delta_free=1e3 * RESPONSE.delta_free),
        1e3 * TARGET,
        replace(
            LIMITS,
            pull_min=1e3 * LIMITS.pull_min,
            pull_max=1e3 * LIMITS.pull_max,
            rate=1e3 * LIMITS.rate,
        ),
        1e3 * PULL,
        H,
        EPSILON,
    )
    np.testing.assert_allclose(millimetres.Q, 1e6 * metres.Q, rtol=1e-12)
    np.testing.assert_allclose(millimetres.g_hi, 1e3 * metres.g_hi, rtol=1e-9, atol=1e-12)


def test_contacts_kept_shut_stiffen_what_the_cables_move() -> None:
    """W̃_ea is what the effectors move when the gaps of the touching contacts may not."""
    touching = np.array([True, False, True, False])
    c = 3 + N_A + np.flatnonzero(touching)
    for column in range(N_A):
        lam = np.zeros(len(RESPONSE.W))
        lam[3 + column] = 1.0
        lam[c] = np.linalg.solve(RESPONSE.W[np.ix_(c, c)], -RESPONSE.W[c, 3 + column])
        expected = (RESPONSE.W @ lam)[:3]
        np.testing.assert_allclose(shut(RESPONSE, touching)[:, column], expected, rtol=1e-6)
    nothing = np.zeros(K, dtype=np.bool_)
    np.testing.assert_array_equal(shut(RESPONSE, nothing), RESPONSE.W[:3, 3 : 3 + N_A])


@pytest.mark.parametrize("kind", ["twins", "rigid", "all rigid"])
def test_contacts_without_compliance_of_their_own_are_no_trouble(kind: str) -> None:
    W = RESPONSE.W.copy()
    first, second = 3 + N_A, 4 + N_A
    if kind == "twins":
        W[second], W[:, second] = W[first], W[:, first]
        W[second, second] = W[first, first]
    else:
        rigid = slice(first, None if kind == "all rigid" else second)
        W[rigid], W[:, rigid] = 0.0, 0.0
    stiff = shut(replace(RESPONSE, W=W), np.ones(K, dtype=np.bool_))
    assert np.isfinite(stiff).all()
    assert np.abs(stiff).max() <= 1.01 * np.abs(W[:3]).max()


def test_more_weight_on_energy_takes_less_of_it() -> None:
    W_aa = RESPONSE.W[3 : 3 + N_A, 3 : 3 + N_A]
    energies = []
    for epsilon in (1e-6, 1e-2, 1.0, 100.0):
        solution = solve_qpcc(replace(problem_of(epsilon), G=np.zeros((N_A, N_A + K))))
        energies.append(solution.lam_a @ W_aa @ solution.lam_a)
    assert all(later <= before for before, later in pairwise(energies))
    assert energies[-1] < 0.1 * energies[0]


def test_the_scale_without_coupling() -> None:
    W_aa = np.diag([1e-4, 3e-4])
    assert energy_scale(np.zeros((3, 2)), W_aa) == pytest.approx(2e-4)
    assert energy_scale(np.zeros((3, 2)), np.zeros((2, 2))) == 0.0
