"""From campaign to reduced simulation on a robot with two notches."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tauten.model import Enrichment, Robot, Simulator
from tauten.model.numerics import Array
from tauten.reduction.campaign import Design, Snapshots, ramp
from tauten.reduction.contact import (
    BasisError,
    BasisQuality,
    ChoiceError,
    ContactBasis,
    Fit,
    ReduceSettings,
    Reduction,
    coverage,
    factorise,
    provenance,
    reduce_robot,
    tip_errors,
)
from tauten.service.plots import draw_modes

FOUR = ReduceSettings(k=4)


@pytest.fixture(scope="module")
def reduction(thumb: Robot, thumb_design: Design, thumb_folder: Path) -> Reduction:
    return reduce_robot(thumb, thumb_design, thumb_folder, FOUR)


@pytest.fixture(scope="module")
def whole(thumb: Robot, reduction: Reduction) -> ContactBasis:
    """A unit column for every candidate."""
    return basis_of(thumb, reduction.snapshots, np.eye(thumb.n_c))


def basis_of(robot: Robot, snapshots: Snapshots, Psi: Array) -> ContactBasis:
    """A basis whose provenance says nothing about its quality."""
    nothing = BasisQuality(0.0, 0.0, 0.0)
    origin = provenance(robot, snapshots, ReduceSettings(), Fit(Psi, 0.0, Psi.shape[1]), nothing)
    return ContactBasis(Psi, origin)


def test_basis_records_its_origin(thumb: Robot, reduction: Reduction) -> None:
    origin = reduction.basis.provenance
    assert (origin.robot, origin.robot_digest) == ("thumb", thumb.digest)
    assert (origin.k, origin.method, origin.weighting, origin.seed) == (4, "energy", "equal", 0)
    assert origin.campaign.startswith("ramp: each cable to its largest pull in 40 steps [")
    assert origin.snapshots == len(reduction.snapshots) == 40 - reduction.skipped
    assert origin.snapshots_digest == reduction.snapshots.digest()
    assert 0.0 < origin.error < 0.2
    assert 0.0 < origin.energy_error < 0.1


def test_reduction_is_reproduced(thumb: Robot, tmp_path: Path) -> None:
    first, again = (
        reduce_robot(thumb, ramp(thumb, step=1e-3), tmp_path / name, FOUR)
        for name in ("first", "again")
    )
    np.testing.assert_array_equal(again.basis.Psi, first.basis.Psi)


@pytest.mark.long
def test_automatic_k_is_the_smallest_within_tolerance(
    thumb: Robot, thumb_design: Design, thumb_folder: Path
) -> None:
    settings = ReduceSettings(k="auto", tolerance=2e-4)
    found = reduce_robot(thumb, thumb_design, thumb_folder, settings)
    curve = {point.k: point.tip for point in found.basis.provenance.curve}
    assert curve[found.basis.k] <= 2e-4
    assert all(error > 2e-4 for k, error in curve.items() if k < found.basis.k)
    assert found.curve is not None
    np.testing.assert_array_equal(found.curve.k, list(curve))


def test_too_many_modes_are_refused(thumb: Robot, tmp_path: Path) -> None:
    many = ReduceSettings(k=1000)
    with pytest.raises(ChoiceError, match="k = 1000 modes requested, but the snapshots have rank"):
        reduce_robot(thumb, ramp(thumb, step=1e-3), tmp_path, many)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"k": 0}, "k is 0: allowed are 1 and more, and auto"),
        ({"method": "svd"}, "method 'svd' is unknown: choose one of energy, hals, "),
        ({"weighting": "none"}, "weighting 'none' is unknown: choose one of equal, force"),
        ({"tolerance": 0.0}, "tolerance is 0.0 m: it must be positive"),
    ],
)
def test_settings_that_make_no_sense(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(ChoiceError, match=message):
        ReduceSettings(**settings)


def test_basis_of_another_robot_is_refused(
    thumb: Robot, finger: Robot, reduction: Reduction
) -> None:
    reduction.basis.check_robot(thumb)
    with pytest.raises(
        BasisError, match=r"made for robot 'thumb', which is not 'finger' as it is now.*`tauten red"
    ):
        reduction.basis.check_robot(finger)


def test_whole_basis_steps_like_pointwise_contact(thumb: Robot, whole: ContactBasis) -> None:
    """Same state, same pull, no penetration left to either: the same step."""
    tight = Enrichment(tolerance=1e-11, rounds=60, per_pair=8)
    pointwise = Simulator(thumb, contact="full", enrichment=tight)
    reduced = Simulator(thumb, contact=whole)
    for position in np.linspace(0.0005, 0.006, 12):
        reduced.start_from(pointwise.state, reduced.forces)
        pointwise.step(position=[position])
        reduced.step(position=[position])
        np.testing.assert_allclose(reduced.effector, pointwise.effector, atol=1e-8)
        np.testing.assert_allclose(reduced.effort, pointwise.effort, rtol=1e-6)
    assert pointwise.lam_c.sum() > 1.0, "there was contact"


def test_modes_carry_the_contact(thumb: Robot, reduction: Reduction) -> None:
    """Closed notches make the cable pull three times as hard; four modes know it within 3 %."""
    path = reduction.snapshots.select(np.arange(3, len(reduction.snapshots), 4))
    free, reduced = Simulator(thumb, contact="none"), Simulator(thumb, contact=reduction.basis)
    for i in range(len(path)):
        free.settle(position=path.position[:, i])
        assert reduced.settle(position=path.position[:, i]).converged
        np.testing.assert_allclose(reduced.effort, path.effort[:, i], rtol=0.03)
    assert free.effort[0] < 0.4 * path.effort[0, -1]


def test_modes_keep_the_tip_in_place(thumb: Robot, reduction: Reduction) -> None:
    path = reduction.snapshots.select(np.arange(3, len(reduction.snapshots), 4))
    reduced = tip_errors(thumb, path, reduction.basis)
    assert reduced.converged.all()
    assert np.nanmax(reduced.error) < 0.003 * thumb.body.mesh.size
    assert not reduced.extra_columns.any()


@pytest.mark.long
def test_more_modes_and_enrichment_come_closer(thumb: Robot, reduction: Reduction) -> None:
    path = reduction.snapshots.select(np.arange(3, len(reduction.snapshots), 6))
    found = factorise(reduction.snapshots.lam, 1)
    poor = basis_of(thumb, reduction.snapshots, found.Psi)
    alone = np.nanmax(tip_errors(thumb, path, poor).error)
    assert tip_errors(thumb, path, reduction.basis).error.max() < 0.5 * alone
    tight = Enrichment(tolerance=1e-8, rounds=60, per_pair=8)
    enriched = tip_errors(thumb, path, poor, tight)
    assert enriched.error.max() < 1e-5
    assert enriched.extra_columns.any()


def test_coverage_names_the_candidates_without_mode(thumb: Robot, reduction: Reduction) -> None:
    pairs = coverage(thumb, reduction.basis)
    assert len(pairs) == 2
    np.testing.assert_array_equal(np.concatenate([pair.slots for pair in pairs]), np.arange(48))
    untouched = np.concatenate([pair.untouched for pair in pairs])
    np.testing.assert_array_equal(untouched, reduction.basis.untouched())
    assert 0 < len(untouched) < 48
    assert {mode for pair in pairs for mode in pair.modes} == set(range(4))


def test_candidates_lie_in_the_notches(thumb: Robot) -> None:
    points = thumb.candidates(thumb.rest())
    assert points.shape == (48, 3)
    assert (points[:, 0] > 0.005).all()
    nearest = np.abs(points[:, 2, None] + np.array([0.05 / 3, 0.1 / 3])).min(axis=1)
    assert nearest.max() < 0.001


def test_modes_are_drawn(thumb: Robot, reduction: Reduction, tmp_path: Path) -> None:
    draw_modes(thumb, reduction.basis, tmp_path / "modes.png")
    assert (tmp_path / "modes.png").read_bytes().startswith(b"\x89PNG")
