"""The complementarity solvers against each other, against other libraries, and on contact problems."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls

from benchmarks.contact_basis import solve_pgs
from tauten.model.numerics import Array, complementarity, solve_lcp


def contact_problem(
    rng: np.random.Generator, points: int, nodes: int
) -> tuple[Array, Array, Array]:
    """W = P C Pᵀ of points interpolated on fewer nodes of an elastic line, gaps with both signs.

    Returns W, delta_free and the factor B with W = B Bᵀ.
    """
    u, at = np.linspace(0.0, 1.0, points), np.linspace(0.0, 1.0, nodes)
    P = np.maximum(0.0, 1.0 - np.abs(u[:, None] - at) * (nodes - 1))  # (points, nodes)
    C = 1e-3 * np.exp(-np.abs(at[:, None] - at) / 0.2) + 1e-4 * np.eye(nodes)
    B = P @ np.linalg.cholesky(C)
    waves = sum(
        rng.normal() * np.sin((k + 1) * np.pi * u + rng.uniform(0, 6)) / (k + 1) for k in range(6)
    )
    return B @ B.T, 1e-3 * waves, B


def nnls_gaps(B: Array, delta_free: Array) -> tuple[Array, Array]:
    """Gaps and forces by scipy: min |Bᵀλ − c|² with B c = −δ_free, λ ≥ 0."""
    c = -np.linalg.lstsq(B, delta_free, rcond=None)[0]
    np.testing.assert_allclose(B @ c, -delta_free, atol=1e-15)
    lam, _ = nnls(B.T, c, maxiter=100_000)
    return delta_free + B @ (B.T @ lam), lam


problems = st.builds(
    lambda seed, points, nodes: (np.random.default_rng(seed), points, nodes),
    st.integers(0, 10_000),
    st.sampled_from([1, 2, 7, 40, 150]),
    st.sampled_from([2, 5, 20, 60]),
)


@settings(max_examples=60, deadline=None)
@given(problems)
def test_exact_solver_meets_every_condition(problem: tuple[np.random.Generator, int, int]) -> None:
    W, delta_free, _ = contact_problem(*problem)
    result = solve_lcp(W, delta_free)
    assert result.converged
    assert result.residual <= 1e-9
    assert result.lam.min() >= 0.0
    assert result.delta.min() >= -1e-9
    assert np.abs(result.lam * result.delta).max() <= 1e-9 * (1.0 + result.lam.max())
    np.testing.assert_allclose(result.delta, delta_free + W @ result.lam, atol=1e-15)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([3, 20, 60]))
def test_exact_solver_agrees_with_nnls(seed: int, nodes: int) -> None:
    """Gaps are unique; delta_free in the range of B is what nnls needs."""
    rng = np.random.default_rng(seed)
    W, _, B = contact_problem(rng, 80, nodes)
    delta_free = 1e-3 * B @ rng.normal(size=nodes) / np.abs(B).max()
    expected, lam = nnls_gaps(B, delta_free)
    result = solve_lcp(W, delta_free)
    np.testing.assert_allclose(result.delta, expected, atol=2e-9)
    # of the many forces, those of nearly the least norm
    assert np.sqrt(np.diag(W) @ result.lam**2) <= np.sqrt(np.diag(W) @ lam**2) * (1 + 1e-6)


@pytest.mark.long
@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([3, 10, 30]))
def test_gauss_seidel_agrees_with_the_exact_solver(seed: int, nodes: int) -> None:
    W, delta_free, _ = contact_problem(np.random.default_rng(seed), 60, nodes)
    reference = solve_pgs(W, delta_free, tolerance=1e-10, max_sweeps=100_000)
    assert reference.converged
    np.testing.assert_allclose(solve_lcp(W, delta_free).delta, reference.delta, atol=1e-7)


def test_one_contact_by_hand() -> None:
    W = np.array([[2e-3]])
    pressed = solve_lcp(W, np.array([-1e-3]))
    np.testing.assert_allclose(pressed.lam, [0.5], rtol=1e-8)
    apart = solve_lcp(W, np.array([1e-3]))
    assert apart.lam.tolist() == [0.0]
    assert apart.iterations == 0


def test_a_wound_cable_and_a_contact_in_one_problem() -> None:
    """δ_a − pull = W_aa T + W_ac λ − pull: the cable remains taut, the contact has a force."""
    W = np.array([[4e-3, -1e-3], [-1e-3, 2e-3]])
    position, gap = 8e-3, 1e-3
    result = solve_lcp(W, np.array([-position, gap]))
    expected = np.linalg.solve(W, [position, -gap])
    assert expected.min() > 0.0
    np.testing.assert_allclose(result.lam, expected, rtol=1e-7)
    slack = solve_lcp(W, np.array([1e-3, gap]))  # a cable let out only goes slack
    assert slack.lam.tolist() == [0.0, 0.0]


@pytest.mark.long
def test_equal_candidates_share_the_force_wherever_it_starts() -> None:
    """Four candidates on one node: W has rank 1, the least-norm forces are equal."""
    W, delta_free = np.full((4, 4), 1e-3), np.full(4, -2e-3)
    for start in (None, np.array([2.0, 0, 0, 0]), np.array([0, 0, 5.0, 5.0])):
        np.testing.assert_allclose(solve_lcp(W, delta_free, start).lam, np.full(4, 0.5), rtol=1e-6)
    lopsided = solve_pgs(W, delta_free, np.array([2.0, 0, 0, 0]))
    np.testing.assert_allclose(lopsided.lam, [2.0, 0, 0, 0], atol=1e-9)  # the reference keeps it


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_start_changes_time_not_the_result(seed: int) -> None:
    rng = np.random.default_rng(seed)
    W, delta_free, _ = contact_problem(rng, 80, 20)
    cold = solve_lcp(W, delta_free)
    again = solve_lcp(W, delta_free, cold.lam)
    assert again.iterations <= 1
    odd = solve_lcp(W, delta_free, np.maximum(rng.normal(size=80), 0.0))
    np.testing.assert_allclose(odd.delta, cold.delta, atol=1e-12)
    np.testing.assert_allclose(odd.lam, cold.lam, atol=1e-5 * max(1.0, cold.lam.max()))


def test_order_of_rows_does_not_matter() -> None:
    rng = np.random.default_rng(1)
    W, delta_free, _ = contact_problem(rng, 80, 20)
    order = rng.permutation(80)
    shuffled = solve_lcp(W[np.ix_(order, order)], delta_free[order])
    np.testing.assert_allclose(shuffled.lam, solve_lcp(W, delta_free).lam[order], atol=1e-5)


def test_scale_of_units_does_not_matter() -> None:
    """Rows in other units: D W D, D δ_free give D⁻¹ λ, rows differing by 1e3 in size."""
    rng = np.random.default_rng(2)
    W, delta_free, _ = contact_problem(rng, 40, 20)
    D = 10.0 ** rng.uniform(-1.5, 1.5, 40)
    scaled = solve_lcp(D[:, None] * W * D, D * delta_free)
    assert scaled.converged
    np.testing.assert_allclose(scaled.delta / D, solve_lcp(W, delta_free).delta, atol=1e-9)


def test_what_no_force_can_open_is_not_called_solved() -> None:
    stuck = solve_lcp(np.diag([1e-3, 0.0]), np.array([-1e-3, -1e-4]))
    assert not stuck.converged
    assert stuck.residual == pytest.approx(1e-4)
    np.testing.assert_allclose(stuck.lam, [1.0, 0.0], rtol=1e-8)
    squeezed = solve_lcp(np.array([[1.0, -1.0], [-1.0, 1.0]]) * 1e-3, np.array([-1e-3, -1e-3]))
    assert not squeezed.converged
    assert np.isfinite(squeezed.lam).all()
    assert not solve_pgs(np.diag([1e-3, 0.0]), np.array([-1e-3, -1e-4])).converged


def test_gauss_seidel_reports_that_it_has_not_converged() -> None:
    W, delta_free, _ = contact_problem(np.random.default_rng(3), 150, 20)
    early = solve_pgs(W, delta_free, max_sweeps=2)
    assert not early.converged
    assert early.residual > 1e-9
    assert early.iterations == 2


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("where", ["W", "delta_free", "start"])
def test_data_that_are_not_finite_never_raise(value: float, where: str) -> None:
    W, delta_free, start = np.eye(3) * 1e-3, np.array([-1e-3, 1e-3, -2e-3]), np.ones(3)
    {"W": W, "delta_free": delta_free, "start": start}[where][..., 1] = value
    result = solve_lcp(W, delta_free, start)
    assert np.isfinite(result.lam).all()
    assert result.converged == (where == "start")


@pytest.mark.parametrize("solve", [solve_lcp, solve_pgs])
def test_no_rows(solve) -> None:  # type: ignore[no-untyped-def]
    result = solve(np.zeros((0, 0)), np.zeros(0))
    assert result.converged
    assert result.residual == 0.0


def test_residual_is_a_length_of_both_kinds_of_violation() -> None:
    W = np.diag([1e-3, 1e-3, 1e-3])
    open_with_force = complementarity(W, np.array([0.2, 0.0, 0.0]), np.array([5e-4, 1.0, 0.0]))
    assert open_with_force == pytest.approx(2e-4)
    penetrating = complementarity(W, np.array([0.0, 0.0, 0.0]), np.array([1.0, -3e-4, 0.0]))
    assert penetrating == pytest.approx(3e-4)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    rows=st.integers(1, 90),
    rank=st.integers(1, 50),
    kind=st.sampled_from(["independent", "opposed", "repeated", "aligned"]),
)
def test_known_gaps_are_found_again(seed: int, rows: int, rank: int, kind: str) -> None:
    """δ_free = δ* − W λ* from complementary δ*, λ*, a fifth of the rows neither open nor pushing."""
    rng = np.random.default_rng(seed)
    B = 0.03 * rng.standard_normal((rows, rank))
    if kind == "opposed":  # squeezed from both sides
        B[rows // 2 :] = -B[: rows - rows // 2]
    elif kind == "repeated":
        B[rng.integers(0, rows, rows // 2)] = B[0]
    elif kind == "aligned":
        B = np.abs(B)
    W = B @ B.T
    pushing, neither = rng.random(rows) < 0.5, rng.random(rows) < 0.2
    lam = np.where(pushing & ~neither, rng.exponential(1.0, rows), 0.0)
    delta = np.where(~pushing & ~neither, rng.exponential(1e-3, rows), 0.0)
    result = solve_lcp(W, delta - W @ lam)
    assert result.converged
    np.testing.assert_allclose(result.delta, delta, atol=1e-9)


def test_smoother_forces_close_the_same_gaps() -> None:
    """A larger rho costs norm nothing and gaps little: the polish takes its bias away."""
    W, delta_free, _ = contact_problem(np.random.default_rng(5), 150, 20)
    sharp, smooth = solve_lcp(W, delta_free), solve_lcp(W, delta_free, rho=1e-6)
    assert smooth.converged
    np.testing.assert_allclose(smooth.delta, sharp.delta, atol=1e-9)
    weight = np.diag(W)
    assert weight @ smooth.lam**2 <= weight @ sharp.lam**2 * (1.0 + 1e-9)


def test_eigenvalues_of_the_size_of_the_regularisation_are_solved_too() -> None:
    """Two rows whose gaps differ by 1e-10 of their compliance, and forces that differ by a lot."""
    W = np.array([[1.0, 1.0 - 1e-10], [1.0 - 1e-10, 1.0]])
    delta_free = -W @ np.array([1000.0, 1.0])
    result = solve_lcp(W, delta_free)
    assert result.converged
    assert complementarity(W, result.lam, delta_free + W @ result.lam) <= 1e-9
