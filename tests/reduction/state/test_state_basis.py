"""State bases as files: whole or refused, and the shipped one fits the shipped robot."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.examples import shipped_robot

from tauten.controller import load_model_settings
from tauten.model import Robot
from tauten.model.tetra import NodalBody
from tauten.reduction.contact import ContactBasis
from tauten.reduction.state import StateBasis, StateBasisError, StateOrigin


@pytest.fixture
def states() -> StateBasis:
    rng = np.random.default_rng(0)
    origin = StateOrigin(
        robot="thing", robot_digest="0" * 64, campaign="none", snapshots_digest="1" * 64,
        snapshots=9, r=3, responses=1, projection_error=1e-3, sample=2, sample_tolerance=1e-2,
        sample_error=9e-3, tip_mean=1e-4, tip_max=2e-4, seed=0, created="2026-01-01T00:00:00+00:00",
        versions=(("python", "3.11"),),
    )  # fmt: skip
    return StateBasis(rng.normal(size=(12, 3)), np.array([1, 5]), np.array([2.0, 3.5]), origin)


def test_file_gives_back_what_was_saved(states: StateBasis, tmp_path: Path) -> None:
    found = StateBasis.load(states.save(tmp_path / "thing.states"))
    np.testing.assert_array_equal(found.Phi, states.Phi)
    np.testing.assert_array_equal(found.elements, states.elements)
    np.testing.assert_array_equal(found.weights, states.weights)
    assert found.origin == states.origin
    assert found.digest() == states.digest()


def test_different_bases_have_different_digests(states: StateBasis) -> None:
    other = dataclasses.replace(states, weights=states.weights + 1e-12)
    assert other.digest() != states.digest()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"Phi": np.zeros((12, 2))}, r"expected \(n, 3\)"),
        ({"Phi": np.full((12, 3), np.nan)}, "not finite"),
        ({"Phi": np.zeros((0, 3))}, "no entries"),
        ({"weights": np.array([1.0, -1.0])}, "positive and finite"),
        ({"weights": np.array([1.0, np.inf])}, "positive and finite"),
        ({"elements": np.array([1])}, "one weight for each element"),
        ({"elements": np.array([5, 1])}, "ascending numbers"),
        ({"elements": np.array([5, 5])}, "ascending numbers"),
        ({"elements": np.array([-1, 5])}, "ascending numbers"),
        ({"elements": np.array([1]), "weights": np.array([1.0])}, "expected 2, sample as in"),
    ],
)
def test_nonsense_is_refused(states: StateBasis, changes: dict[str, object], said: str) -> None:
    with pytest.raises(StateBasisError, match=said):
        dataclasses.replace(states, **changes)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("mean", "largest"),
    [(-1e-4, 2e-4), (3e-4, 2e-4), (1e-4, np.inf), (np.nan, 2e-4), (1e-4, np.nan)],
)
def test_impossible_tip_errors_are_refused(states: StateBasis, mean: float, largest: float) -> None:
    with pytest.raises(StateBasisError, match="expected 0 ≤ tip_mean ≤ tip_max"):
        states.with_tip_errors(mean, largest)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda s: {"Phi": 2.0 * s.Phi}, "not orthonormal in the mass"),
        (lambda s: {"Phi": 0.0 * s.Phi}, "not orthonormal in the mass"),
        (lambda s: {"weights": 3.0 * s.weights}, "times the volume of robot 'finger'"),
        (lambda s: {"weights": 0.3 * s.weights}, "times the volume of robot 'finger'"),
        (lambda s: {"elements": s.elements + 10**6}, r"has the elements 0 to \d+"),
        (lambda s: {"origin": dataclasses.replace(s.origin, tip_max=0.2)}, "more than the size"),
    ],
)
def test_file_that_does_not_describe_the_body_is_refused(
    shipped_finger: Robot[NodalBody],
    tmp_path: Path,
    change: Callable[[StateBasis], dict[str, Any]],
    said: str,
) -> None:
    """With a digest that matches: the content itself is compared with the robot."""
    shipped = StateBasis.load("finger")
    path = dataclasses.replace(shipped, **change(shipped)).save(tmp_path / "finger.states")
    with pytest.raises(StateBasisError, match=said):
        StateBasis.load(path).check_robot(shipped_finger)


def test_names_and_kinds_of_files_are_checked(states: StateBasis, tmp_path: Path) -> None:
    with pytest.raises(StateBasisError, match=r"ends in \.states"):
        states.save(tmp_path / "thing.npz")
    with pytest.raises(StateBasisError, match=r"expected a path ending in \.states"):
        StateBasis.load("nobody")
    with pytest.raises(StateBasisError, match="no state basis can be read there"):
        StateBasis.load(tmp_path / "missing.states")
    other = ContactBasis.load("finger").save(tmp_path / "finger.basis")
    other.rename(tmp_path / "finger.states")
    with pytest.raises(StateBasisError, match="expected a tauten state basis file"):
        StateBasis.load(tmp_path / "finger.states")


def test_tip_error_beyond_what_is_allowed_is_refused(states: StateBasis) -> None:
    states.check_tip(2e-4)
    with pytest.raises(StateBasisError, match=r"up to 0\.2 mm \(mean 0\.1 mm\)"):
        states.check_tip(1.9e-4)
    with pytest.raises(StateBasisError, match="nan"):  # never measured
        states.with_tip_errors(float("nan"), float("nan")).check_tip(1.0)


def test_shipped_basis_fits_the_shipped_finger(shipped_finger: Robot[NodalBody]) -> None:
    finger = shipped_finger
    states = StateBasis.load("finger")
    states.check_robot(finger)
    states.check_tip(load_model_settings("finger").max_tip_error)
    assert states.origin.tip_mean < 2e-3 * 0.1  # a fifth of a percent of its length
    product = (
        states.Phi.T
        @ (finger.body.tetrahedra.mass[:, None] * states.Phi)
        / (finger.body.tetrahedra.mass.sum() / 3.0)
    )
    np.testing.assert_allclose(product, np.eye(states.r), atol=1e-9)


@pytest.mark.long
def test_shipped_basis_fits_the_shipped_manipulator() -> None:
    states, robot = StateBasis.load("manipulator"), shipped_robot("manipulator")
    states.check_robot(robot)
    states.check_tip(load_model_settings("manipulator").max_tip_error)
    assert states.origin.tip_mean < 2e-3 * robot.size
    assert states.origin.tip_max < 1e-2 * robot.size
