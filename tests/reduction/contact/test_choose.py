from pathlib import Path

import numpy as np
import pytest

from tauten.model.numerics import Ints
from tauten.reduction.campaign import Origin, Snapshots
from tauten.reduction.contact import (
    ChoiceError,
    ContactProblem,
    Curve,
    choose_k,
    cross_validate,
    folds,
)
from tauten.service.plots import draw_curve

Problems = tuple[ContactProblem, ...]


def with_runs(run: Ints) -> Snapshots:
    s = len(run)
    nothing = np.zeros((0, s))
    flags = np.ones(s, dtype=bool)
    return Snapshots(
        *[nothing] * 4,
        gravity=np.zeros((3, s)),
        effector_force=nothing,
        pressed=nothing,
        run=run,
        converged=flags,
        q=nothing,
        origin=Origin("", "", "", ()),
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
def curve(thumb_ramp: Snapshots, thumb_problems: Problems) -> Curve:
    S = thumb_ramp.lam
    return cross_validate(S, folds(thumb_ramp), thumb_problems, ks=(1, 2, 4, 8, 10_000))


def test_held_out_error_is_above_training_and_falls(curve: Curve) -> None:
    np.testing.assert_array_equal(curve.k, [1, 2, 4, 8])  # 10,000 is beyond the rank
    assert (np.diff(curve.training) < 0.0).all()
    assert curve.training[-1] < 0.5 * curve.training[0]
    assert (curve.held_out >= 0.99 * curve.training).all()
    for falls, share in ((curve.held_out, 0.6), (curve.force, 0.6), (curve.tip, 0.9)):
        assert falls[-1] < share * falls[0]
        assert (falls > 0.0).all()


def test_a_contact_absent_from_training_is_an_error(
    thumb_ramp: Snapshots, thumb_problems: Problems
) -> None:
    """Modes fitted to light contact do not hold what closes later."""
    late = (np.arange(len(thumb_ramp)) > 0.7 * len(thumb_ramp)).astype(np.int64)
    mixed = np.arange(len(thumb_ramp)) // 4 % 2
    never, present = (
        cross_validate(thumb_ramp.lam, fold, thumb_problems, ks=(4,)) for fold in (late, mixed)
    )
    assert never.held_out[0] > 1.3 * present.held_out[0]


def test_auto_takes_the_smallest_good_k(curve: Curve) -> None:
    for index in range(len(curve.k)):
        tolerance = 1.0001 * curve.tip[index]
        chosen = choose_k(curve, tolerance)
        assert curve.tip[curve.k == chosen] <= tolerance
        assert (curve.tip[curve.k < chosen] > tolerance).all()
    with pytest.raises(
        ChoiceError, match=r"no k up to 8 .* within 1e-06 mm: the best is .* k = [48]"
    ):
        choose_k(curve, 1e-9)
    assert choose_k(curve, 1e-9, needed=False) == curve.k[np.argmin(curve.tip)]


def test_no_k_within_the_rank(thumb_ramp: Snapshots, thumb_problems: Problems) -> None:
    with pytest.raises(ValueError, match="to the rank of the snapshots"):
        cross_validate(thumb_ramp.lam, folds(thumb_ramp), thumb_problems, ks=(10_000,))


def test_curve_is_drawn(curve: Curve, tmp_path: Path) -> None:
    draw_curve(curve, tmp_path / "curve.png", chosen=8)
    assert (tmp_path / "curve.png").read_bytes().startswith(b"\x89PNG")
