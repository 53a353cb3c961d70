"""Errors of runs of effectors of every kind: distance, angle, difference of volumes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tauten.model import load_robot
from tauten.model.schema import EffectorKind
from tauten.service.plots import draw_run
from tauten.service.replay import RecordedRun, errors_to_goal, read_run, table_rows
from tauten.service.replay.report import Series, apart, error, make_report

LOG = Path(__file__).parents[2] / "reference" / "runs" / "finger.mcap"


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 0.5, 2.0, 3.1, np.pi])
def test_the_angle_between_rotations_is_exact(angle: float) -> None:
    axis = np.array([0.6, 0.0, -0.8])
    start = Rotation.from_rotvec([0.3, 0.2, -0.1])
    end = Rotation.from_rotvec(angle * axis) * start
    first, second = (
        np.array([[0.0, 0.0, 0.0, *rotation.as_quat()[[3, 0, 1, 2]]]]) for rotation in (start, end)
    )
    for sign in (1.0, -1.0):
        second[:, 3:] *= sign
        assert apart(first, second)[1][0] == pytest.approx(angle, rel=1e-6, abs=1e-12)


def run_of(kind: EffectorKind, size: int) -> RecordedRun:
    """The recorded run of the finger with made-up values of another kind."""
    run = read_run(LOG)
    rng = np.random.default_rng(1)

    def made(count: int) -> np.ndarray:
        values = 0.1 + 1e-3 * rng.standard_normal((count, size))
        if size == 7:
            values[:, 3:] = [1.0, 0.0, 0.0, 0.0]
        return values

    goal = np.where(np.isfinite(run.goal[:, :1]), made(len(run.time)), np.nan)
    model = Series(run.time, made(len(run.time)))
    plant = Series(run.time, made(len(run.time)))
    return replace(run, kind=kind, goal=goal, model=model, plant=plant)


@pytest.mark.parametrize(
    ("kind", "size", "unit"),
    [
        ("frame", 7, "mrad"),
        pytest.param("distance", 1, "mm", marks=pytest.mark.slow),
        ("volume", 1, "ml"),
    ],
)
def test_a_run_of_any_kind_is_reported_and_drawn(
    kind: EffectorKind, size: int, unit: str, tmp_path: Path
) -> None:
    run = run_of(kind, size)
    report = make_report(run)
    row = dict(table_rows(report))["tracking error of the plant, RMS / max"]
    assert row.endswith(unit)
    assert ("mm" in row) == (kind != "volume")
    distance, angle = errors_to_goal(run, run.plant)
    assert np.isfinite(distance).any()
    assert np.isfinite(angle).any() == (kind == "frame")
    draw_run(run, load_robot("finger").actuators, tmp_path / "run.png")
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


def test_units_of_errors() -> None:
    found = error("frame", np.array([0.003, np.nan]), np.array([0.02, 0.01]))
    assert found.max_mm == pytest.approx(3.0)
    assert found.max_mrad == pytest.approx(20.0)
    assert error("volume", np.array([2e-6]), np.array([np.nan])).max_ml == pytest.approx(2.0)
    assert error("point", np.array([np.nan]), np.array([np.nan])).rms_mm is None
