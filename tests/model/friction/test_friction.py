"""Contact with friction: problems that others wrote, and mechanics that has a closed solution."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from benchmarks.friction import read_problem
from tauten.model.friction import (
    Cones,
    FrictionProblem,
    certify_friction,
    smoothed_law,
    solve_friction,
    widths,
)
from tauten.model.numerics import Array

H = 1e-2  # s, step
GRAVITY = 9.81
FEW = 60  # linear systems, within which no path is tried
LARGE = ("Capsules", "spheres")  # of 225 and more contacts, which take seconds


def block(width: float, height: float) -> tuple[Array, Array]:
    """Rows H_c (12, 6) of the four lower corners of a block, normal, x and y each, and its M⁻¹ (6,); 1 kg."""
    corners = [(x, y, -0.5 * height) for x in (-0.5, 0.5) for y in (-0.5 * width, 0.5 * width)]
    rows = []
    for at in corners:
        for along in ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)):
            rows.append(np.concatenate([along, np.cross(at, along)]))
    squares = np.array([1.0, width, height]) ** 2
    return np.array(rows), np.concatenate([np.ones(3), 12.0 / (squares.sum() - squares)])


def slid(angle: float, mu: float, steps: int = 50) -> Array:
    """Velocity (6,) of a block on an incline along x after some steps from rest."""
    rows, inverse = block(1.0, 0.2)
    pulled = GRAVITY * np.array([np.sin(angle), 0.0, -np.cos(angle), 0.0, 0.0, 0.0])
    v, r = np.zeros(6), np.zeros(12)
    for _ in range(steps):
        problem = FrictionProblem(
            (rows * inverse) @ rows.T, rows @ (v + H * pulled), np.full(4, mu)
        )
        solution = solve_friction(problem, r)
        assert solution.converged
        r = solution.r
        v = v + H * pulled + inverse * (rows.T @ r)
    return v


@pytest.mark.parametrize("mu", [0.2, 0.6])
def test_a_block_on_an_incline_sticks_below_the_angle_of_friction_and_slides_above(
    mu: float,
) -> None:
    border = np.arctan(mu)
    assert np.abs(slid(border - 0.01, mu)).max() < 1e-9
    angle = border + 0.05
    v = slid(angle, mu)
    expected = 50 * H * GRAVITY * (np.sin(angle) - mu * np.cos(angle))
    assert v[0] == pytest.approx(expected, rel=1e-6)
    assert np.abs(v[1:]).max() < 1e-6 * expected


def test_a_block_on_four_corners_has_forces_that_are_not_unique() -> None:
    rows, inverse = block(1.0, 0.2)
    pushed = np.array([0.01, 0.005, -H * GRAVITY, 0.0, 0.0, 0.0])
    problem = FrictionProblem((rows * inverse) @ rows.T, rows @ pushed, np.full(4, 0.5))
    solution = solve_friction(problem)
    found = certify_friction(problem, solution.r)
    assert found.indeterminate
    assert found.sticking.all()
    assert (found.margin > 0.0).all()
    assert solution.r[0::3].sum() == pytest.approx(H * GRAVITY)
    one = np.array([0, 1, 2])
    alone = FrictionProblem(problem.W[np.ix_(one, one)], problem.q[one], np.array([0.5]))
    assert not certify_friction(alone, solve_friction(alone).r).indeterminate


def test_slip_is_against_the_force_in_every_direction() -> None:
    rows, inverse = block(1.0, 0.2)
    W = (rows * inverse) @ rows.T
    for angle in np.linspace(0.0, 2.0 * np.pi, 13):
        v = np.array([np.cos(angle), np.sin(angle), -H * GRAVITY, 0.0, 0.0, 0.5])
        problem = FrictionProblem(W, rows @ v, np.full(4, 0.3))
        found = certify_friction(problem, solve_friction(problem).r)
        assert found.error < 1e-9
        assert not found.sticking.any()
        assert found.closed.any()
        assert found.angle < 1e-6
        assert found.cone < 1e-9
        assert found.work < 0.0


@pytest.mark.parametrize("mu", [1.2, 1.5])
def test_a_rod_that_slides_on_its_end_may_move_in_two_ways_from_a_friction_on(mu: float) -> None:
    """Painlevé: a thin rod of half-length one at 45°; w_nn = 1/m + cos²/J, w_nt = sin cos / J, J = m/3.

    So that w_nn = 2.5 and w_nt = 1.5: beyond a friction of 5/3 its end opens under its own force.
    """
    W = np.array([[2.5, 1.5, 0.0], [1.5, 2.5, 0.0], [0.0, 0.0, 1.0]])
    problem = FrictionProblem(W, np.array([-0.1, -1.0, 0.0]), np.array([mu]))
    found = certify_friction(problem, solve_friction(problem).r)
    assert found.closed.all()
    assert not found.motion_indeterminate
    assert found.doubts == ()
    rougher = FrictionProblem(W, problem.q, np.array([mu + 0.6]))
    again = certify_friction(rougher, np.array([0.1, 0.1, 0.0]))
    assert again.motion_indeterminate
    assert again.doubts == ("motion may be indeterminate",)


def test_a_solution_that_still_holds_costs_nothing() -> None:
    rows, inverse = block(1.0, 0.2)
    pushed = np.array([0.02, 0.0, -H * GRAVITY, 0.0, 0.0, 0.0])
    problem = FrictionProblem((rows * inverse) @ rows.T, rows @ pushed, np.full(4, 0.5))
    first = solve_friction(problem)
    again = solve_friction(problem, first.r)
    assert first.newton > 0
    assert again.newton == 0
    np.testing.assert_array_equal(again.r, first.r)


def test_a_budget_ends_a_solution_with_the_best_forces() -> None:
    rows, inverse = block(1.0, 0.2)
    pushed = np.array([0.2, 0.1, -H * GRAVITY, 0.0, 0.3, 0.0])
    problem = FrictionProblem((rows * inverse) @ rows.T, rows @ pushed, np.full(4, 0.5))
    cut = solve_friction(problem, budget=1)
    assert cut.newton <= 1
    assert not cut.converged
    assert cut.error <= problem.error(np.zeros(12))


@pytest.mark.parametrize("mu", [1.0, 30.0, 300.0])
def test_every_solution_ends_within_its_budget(mu: float) -> None:
    """Singular W and coefficients of friction far beyond those of any material."""
    rng = np.random.default_rng(0)
    for _ in range(30):
        factor = rng.normal(size=(12, 8))
        problem = FrictionProblem(factor @ factor.T, rng.normal(size=12), np.full(4, mu))
        solution = solve_friction(problem, budget=60)
        assert solution.newton <= 60
        assert solution.error <= problem.error(np.zeros(12))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"mu": np.array([-0.1])}, "mu: found a value that is negative"),
        ({"mu": np.array([np.nan])}, "mu: found a value that is negative or not finite"),
        ({"q": np.zeros(4)}, "q: found 4 rows for 1 contacts"),
        ({"W": np.eye(2)}, "W: found shape"),
        ({"W": np.zeros((3, 3))}, "W: found a contact without compliance"),
        ({"q": np.array([0.0, np.inf, 0.0])}, "W, q: found values that are not finite"),
    ],
)
def test_problems_that_are_none_are_refused(change: dict[str, Array], said: str) -> None:
    given = {"W": np.eye(3), "q": np.zeros(3), "mu": np.array([0.5])} | change
    with pytest.raises(ValueError, match=said):
        FrictionProblem(given["W"], given["q"], given["mu"])


def redundant(seed: int, dim: int) -> FrictionProblem:
    """20 contacts of bodies with 13 or 9 unknowns, of which each contact moves some; a force holds all."""
    rng, m = np.random.default_rng(seed), 20
    rank = 13 if dim == 3 else 9
    G = rng.normal(size=(m * dim, rank)) * (rng.uniform(size=(m, rank)) < 0.3).repeat(dim, 0)
    G[~G.any(axis=1), 0] = 1.0
    G *= np.exp(rng.normal(size=m)).repeat(dim)[:, None]
    return FrictionProblem(G @ G.T, G @ rng.normal(size=rank), rng.uniform(0.05, 1.0, m))


@pytest.mark.long
@pytest.mark.parametrize("dim", [2, 3])
def test_redundant_contacts_are_solved_where_newtons_steps_fail(dim: int) -> None:
    """Some of 60 problems fail within few Newton steps, and at most one with paths."""
    failed, missed = list[int](), list[int]()
    for seed in range(60):
        problem = redundant(seed, dim)
        largest = np.abs(problem.q).max()
        if certify_friction(problem, solve_friction(problem, budget=FEW).r).error > 1e-9 * largest:
            failed.append(seed)
        if certify_friction(problem, solve_friction(problem).r).error > 1e-9 * largest:
            missed.append(seed)
    assert len(failed) >= 2
    assert len(missed) <= 1


def test_exact_forces_meet_the_smoothed_law_within_its_widths() -> None:
    """At every width, and whether contacts are open, stick or slip."""
    for seed in range(12):
        problem = redundant(seed, 3)
        found = solve_friction(problem)
        cones = Cones(problem.W, problem.q, problem.mu, problem.compliance)
        for share in (1.0, 1e-2, 1e-4):
            width = widths(problem.compliance, found.r, share, float(np.abs(problem.q).max()))
            F = smoothed_law(cones, found.u.reshape(-1, 3), found.r, width)
            allowed = (1.0 + 1e-6) * share * width.each
            assert (np.abs(F[:, 0]) <= allowed).all()
            assert (np.linalg.norm(F[:, 1:], axis=1) <= (1.0 + problem.mu) * allowed).all()


def test_tangents_choose_neither_the_compliance_nor_the_error() -> None:
    """A compliance was that of a row, so that a certificate depended on which tangents the rows are along."""
    rng, angles = np.random.default_rng(0), np.linspace(0.0, np.pi, 10_001)
    across = np.stack([0.0 * angles, np.cos(angles), np.sin(angles)], axis=1)
    for seed in range(5):
        problem = redundant(seed, 3)
        m, r = len(problem.mu), rng.standard_normal(len(problem.q))
        turn = block_diag(*(Rotation.from_rotvec([a, 0.0, 0.0]).as_matrix() for a in rng.random(m)))
        turned = FrictionProblem(turn @ problem.W @ turn.T, turn @ problem.q, problem.mu)
        for i, found in enumerate(turned.compliance):
            W = problem.W[3 * i : 3 * i + 3, 3 * i : 3 * i + 3]
            most = max(W[0, 0], np.einsum("ai,ij,aj->a", across, W, across).max())
            assert found == pytest.approx(most, rel=1e-6)
        assert turned.error(turn @ r) == pytest.approx(problem.error(r), rel=1e-12)


def test_a_path_does_not_depend_on_the_unit_of_force() -> None:
    """Forces a million times larger, of contacts as much stiffer."""
    problem = redundant(2, 3)
    assert not solve_friction(problem, budget=FEW).converged
    soft = solve_friction(problem)
    stiff = FrictionProblem(1e-6 * problem.W, problem.q, problem.mu)
    hard = solve_friction(stiff)
    assert soft.converged
    assert hard.converged
    np.testing.assert_allclose(hard.u, soft.u, atol=1e-7 * np.abs(problem.q).max())


@pytest.mark.parametrize("share", [0.4, 2.5])
def test_the_box_stack_of_others_is_solved_with_other_friction_and_pushes(
    reference: Path, share: float
) -> None:
    """Its coefficients of friction changed, and motions that bodies can have added to q."""
    stored = read_problem(reference / "friction_problems" / "BoxesStack-local_problem_test.npz")
    rng, largest = np.random.default_rng(0), np.abs(stored.q).max()
    added = stored.W @ rng.normal(size=len(stored.q))
    for size in (0.0, 0.05, 0.3, 1.0):
        q = stored.q + size * largest / np.abs(added).max() * added
        problem = FrictionProblem(stored.W, q, share * stored.mu)
        error = certify_friction(problem, solve_friction(problem).r).error
        assert error < 1e-9 * np.abs(q).max()


def missed(problem: FrictionProblem) -> float:
    """By how much a solution misses Coulomb's law, contact by contact, as a share of the largest |q|.

    0 <= u_n ⟂ r_n >= 0, |r_t| <= μ r_n, |u_t| r_t = -μ r_n u_t; forces in units of u by the diagonal of W.
    """
    solution = solve_friction(problem)
    assert solution.converged
    shape = (len(problem.mu), problem.dim)
    size, w = np.abs(problem.q).max(), np.diag(problem.W).reshape(shape)[:, :1]
    u = (problem.W @ solution.r + problem.q).reshape(shape) / size
    r = w * solution.r.reshape(shape) / size
    held, speed = problem.mu * r[:, 0], np.linalg.norm(u[:, 1:], axis=1)
    apart = np.abs(np.minimum(u[:, 0], r[:, 0])).max()
    outside = (np.linalg.norm(r[:, 1:], axis=1) - held).max()
    against = np.abs(speed[:, None] * r[:, 1:] + held[:, None] * u[:, 1:]).max()
    return float(max(apart, outside, against))


def test_problems_that_others_wrote_are_solved(reference: Path) -> None:
    files = sorted((reference / "friction_problems").glob("*.npz"))
    assert len(files) == 35
    small = [file for file in files if not file.stem.startswith(LARGE)]
    assert {file.stem for file in small if missed(read_problem(file)) > 1e-9} == set()


@pytest.mark.slow
def test_large_problems_that_others_wrote_are_solved(reference: Path) -> None:
    folder = reference / "friction_problems"
    files = [file for name in LARGE for file in folder.glob(f"{name}*.npz")]
    assert len(files) == 4
    assert max(missed(read_problem(file)) for file in files) < 1e-9
