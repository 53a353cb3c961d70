from pathlib import Path

import numpy as np
import pytest

from tauten.model.arrays import Array, Ints
from tauten.reduction.choose import ChoiceError, Curve, choose_k, cross_validate, folds
from tauten.reduction.curve_figure import draw_curve
from tauten.reduction.snapshots import Origin, Snapshots


def with_runs(run: Ints) -> Snapshots:
    s = len(run)
    nothing = np.zeros((0, s))
    flags = np.ones(s, dtype=bool)
    return Snapshots(
        *[nothing] * 6, run=run, converged=flags, q=nothing, origin=Origin("", "", "", ())
    )


def test_whole_runs_are_held_out() -> None:
    run = np.repeat(np.arange(7), 4)
    fold = folds(with_runs(run), count=5)
    assert all(len(np.unique(fold[run == r])) == 1 for r in range(7))
    np.testing.assert_array_equal(np.unique(fold), np.arange(5))


def test_single_run_is_held_out_in_blocks() -> None:
    fold = folds(with_runs(np.zeros(100, dtype=np.int64)), count=5)
    np.testing.assert_array_equal(np.bincount(fold), np.full(5, 20))
    assert np.count_nonzero(np.diff(fold)) == 39  # forty blocks, no shuffling


@pytest.fixture(scope="module")
def curve(forces: Array) -> Curve:
    fold = folds(with_runs(np.zeros(forces.shape[1], dtype=np.int64)))
    return cross_validate(forces, fold, ks=(1, 2, 4, 8, 16, 10_000))


def test_held_out_error_is_above_training_and_falls(curve: Curve) -> None:
    np.testing.assert_array_equal(curve.k, [1, 2, 4, 8, 16])  # 10,000 is beyond the rank
    assert (np.diff(curve.training) < 0.0).all()
    assert (curve.held_out >= 0.99 * curve.training).all()
    assert curve.held_out[-1] < 0.6 * curve.held_out[0]
    assert (curve.worst > 0.0).all()


def test_a_pattern_never_shown_is_seen_as_error() -> None:
    """Two runs that touch different candidates: nothing of one can be made from the other."""
    S = np.zeros((4, 8))
    S[:2, :4], S[2:, 4:] = np.random.default_rng(0).random((2, 2, 4))
    found = cross_validate(S, np.repeat([0, 1], 4), ks=(1, 2))
    np.testing.assert_allclose(found.held_out, 1.0)
    assert found.training[-1] < 0.8
    np.testing.assert_allclose(found.worst, np.linalg.norm(S, axis=0).max())


def test_auto_takes_the_smallest_good_k(curve: Curve) -> None:
    for index in range(len(curve.k)):
        assert choose_k(curve, 1.0001 * curve.held_out[index]) == curve.k[index]
    with pytest.raises(ChoiceError, match=r"no k up to 16 .* within 1e-06: the best is .* k = 16"):
        choose_k(curve, 1e-6)


def test_no_k_within_the_rank(forces: Array) -> None:
    with pytest.raises(ValueError, match="to the rank of the snapshots"):
        cross_validate(forces, np.arange(forces.shape[1]) % 2, ks=(10_000,))


def test_curve_is_drawn(curve: Curve, tmp_path: Path) -> None:
    draw_curve(curve, tmp_path / "curve.png", chosen=8)
    assert (tmp_path / "curve.png").read_bytes().startswith(b"\x89PNG")
