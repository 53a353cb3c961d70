import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from threadpoolctl import threadpool_limits

from tauten.model.numerics import Array, distances
from tauten.reduction.contact import METHODS, Method, factorise, factorise_each, leading_part

KS = (1, 2, 3, 5, 8, 12, 20, 30)


@pytest.mark.parametrize("method", METHODS)
def test_product_of_nonnegative_factors(forces: Array, method: Method) -> None:
    found = factorise(forces, 5, method)
    assert found.Psi.shape == (len(forces), 5)
    assert found.Psi.min() >= 0.0 and found.B.min() >= 0.0
    np.testing.assert_allclose(np.linalg.norm(found.Psi, axis=0), 1.0, rtol=1e-12)
    residual = np.linalg.norm(forces - found.Psi @ found.B) / np.linalg.norm(forces)
    assert found.error == pytest.approx(residual, rel=1e-9)
    assert found.error < 0.1
    assert not found.Psi[~forces.any(axis=1)].any(), "a candidate without force got some"


@pytest.mark.long
@pytest.mark.parametrize("method", ["hals", "greedy"])
def test_error_never_rises_with_k(forces: Array, method: Method) -> None:
    errors = [found.error for found in factorise_each(forces, KS, method)]
    assert (np.diff(errors) < 0.0).all()
    assert errors[-1] < 0.1 * errors[0]


@pytest.mark.long
def test_als_shows_the_rise_of_the_paper(forces: Array) -> None:
    """Fig. 12 of the paper: the error of Algorithm 1 does not fall with k."""
    errors = [found.error for found in factorise_each(forces, (3, 5, 10, 20, 30), "als")]
    assert max(errors[2:]) > 1.05 * min(errors)


@pytest.mark.long
@pytest.mark.parametrize("k", [5, 10, 20])
def test_default_beats_the_others(forces: Array, k: int) -> None:
    default = factorise(forces, k).error
    for method in METHODS:
        assert default <= 1.02 * factorise(forces, k, method).error


def test_several_k_in_one_run_equal_single_runs(forces: Array) -> None:
    for method in METHODS:
        for found in factorise_each(forces, (7, 2, 4), method):
            np.testing.assert_array_equal(
                found.Psi, factorise(forces, found.k, method).Psi, err_msg=method
            )


def test_greedy_chooses_nested_snapshots(forces: Array) -> None:
    few, many = factorise(forces, 4, "greedy").Psi, factorise(forces, 9, "greedy").Psi
    np.testing.assert_array_equal(few, many[:, :4])
    unit = forces / np.maximum(np.linalg.norm(forces, axis=0), 1e-300)
    assert np.abs(many.T @ unit).max(axis=1) == pytest.approx(1.0)


def test_greedy_bounds_the_worst_snapshot(forces: Array) -> None:
    worst = [distances(found.Psi, forces).max() for found in factorise_each(forces, KS, "greedy")]
    assert (np.diff(worst) <= 1e-9 * worst[0]).all()


@pytest.mark.parametrize("method", METHODS)
def test_order_of_snapshots_does_not_matter(forces: Array, method: Method) -> None:
    shuffle = np.random.default_rng(0).permutation(forces.shape[1])
    one, other = factorise(forces, 6, method), factorise(forces[:, shuffle], 6, method)
    np.testing.assert_array_equal(one.Psi, other.Psi)
    np.testing.assert_array_equal(one.B[:, shuffle], other.B)


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 10_000), k=st.integers(1, 6), method=st.sampled_from(METHODS))
def test_properties_hold_for_any_snapshots(seed: int, k: int, method: Method) -> None:
    rng = np.random.default_rng(seed)
    S = rng.random((12, 9)) * (rng.random((12, 9)) < 0.7)
    if np.linalg.matrix_rank(S) < k:
        return
    found = factorise(S, k, method)
    assert found.Psi.min() >= 0.0 and found.B.min() >= 0.0
    np.testing.assert_allclose(np.linalg.norm(found.Psi, axis=0), 1.0, rtol=1e-12)
    shuffle = rng.permutation(9)
    np.testing.assert_array_equal(factorise(S[:, shuffle], k, method).Psi, found.Psi)


def test_exact_product_is_recovered() -> None:
    rng = np.random.default_rng(1)
    Psi = rng.random((40, 4)) * (rng.random((40, 4)) < 0.3)
    S = Psi @ (rng.random((4, 60)) * (rng.random((4, 60)) < 0.5))
    assert factorise(S, 4).error < 0.01


def test_scale_of_the_forces_does_not_matter(forces: Array) -> None:
    np.testing.assert_allclose(factorise(1024.0 * forces, 5).Psi, factorise(forces, 5).Psi)


def test_leading_part_ignores_the_sign_of_the_pair() -> None:
    u, v = np.array([1.0, -3.0, 0.5]), np.array([-2.0, 1.0])
    for one, other in zip(leading_part(u, v), leading_part(-u, -v), strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_allclose(np.outer(*leading_part(u, v)), [[0, 0], [6, 0], [0, 0]])


def test_nan_columns_are_named(forces: Array) -> None:
    damaged = forces.copy()
    damaged[3, [7, 20]] = np.nan
    with pytest.raises(ValueError, match=r"NaN or infinite forces in columns 7, 20"):
        factorise(damaged, 3)


def test_many_nan_columns_are_counted(forces: Array) -> None:
    with pytest.raises(ValueError, match=r"columns 0, 1, 2, 3, 4 and 145 more"):
        factorise(np.full_like(forces, np.inf), 3)


def test_negative_forces_are_named(forces: Array) -> None:
    damaged = forces.copy()
    damaged[3, 7] = -1.0
    with pytest.raises(ValueError, match=r"negative forces in column 7: contacts only push"):
        factorise(damaged, 3)


def test_rounding_sized_negatives_are_cut(forces: Array) -> None:
    noisy = forces - 1e-12 * forces.max()
    assert factorise(noisy, 3).error == pytest.approx(factorise(forces, 3).error, rel=1e-3)


def test_no_contact_at_all() -> None:
    with pytest.raises(ValueError, match="none of the 5 snapshots has any contact force"):
        factorise(np.zeros((10, 5)), 1)


def test_k_beyond_the_rank() -> None:
    S = np.outer([1.0, 2.0, 3.0], [1.0, 2.0, 0.5, 0.1])
    with pytest.raises(ValueError, match=r"k = 2 modes requested, but the snapshots have rank 1"):
        factorise(S, 2)
    with pytest.raises(ValueError, match="at least 1"):
        factorise(S, 0)


def test_unknown_method_lists_the_methods() -> None:
    with pytest.raises(ValueError, match="'pca' is unknown: choose one of hals, "):
        factorise(np.ones((3, 3)), 1, "pca")  # type: ignore[arg-type]


def test_number_of_threads_does_not_change_a_bit() -> None:
    """Large enough for BLAS to share the sums among its threads, which changes their rounding."""
    rng = np.random.default_rng(0)
    S = rng.random((300, 12)) @ rng.random((12, 400))
    S += 0.1 * rng.random(S.shape) * (rng.random(S.shape) < 0.3)
    found = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            found.append(factorise(S, 2).Psi.tobytes())
    assert found[0] == found[1]
