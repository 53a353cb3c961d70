"""Errors of runs of effectors of every kind: distance, angle, difference of volumes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from tauten.model import Actuators, Robot
from tauten.model.schema import COMPONENTS, EffectorKind
from tauten.service.plots import draw_run
from tauten.service.replay import (
    FOLLOWED,
    RecordedRun,
    Series,
    apart,
    errors_to_goal,
    make_report,
    not_followed,
    read_run,
    table_rows,
)
from tauten.service.replay.report import digits, error
from tauten.service.wire import Cause, Mode

LOG = Path(__file__).parents[2] / "reference" / "runs" / "finger.mcap"


@pytest.fixture(scope="module")
def actuators(shipped_finger: Robot) -> Actuators:
    """The finger's cable."""
    return shipped_finger.actuators


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
        found = apart(first, second, np.ones(6, dtype=bool))[1][0]
        assert found == pytest.approx(angle, rel=1e-6, abs=1e-12)


def test_components_that_are_left_free_do_not_count() -> None:
    """Three millimetres sideways, one up; 10 mrad about its own axis x, 30 about z."""
    start = Rotation.from_rotvec([0.5, -0.3, 0.8])
    end = start * Rotation.from_rotvec([0.01, 0.0, 0.03])
    first, second = (
        np.array([[*position, *rotation.as_quat()[[3, 0, 1, 2]]]])
        for position, rotation in (((0.0, 0.0, 0.0), start), ((0.003, 0.0, 0.001), end))
    )

    def of(*weights: float) -> tuple[float, float]:
        distance, angle = apart(first, second, np.array(weights) > 0.0)
        return float(distance[0]), float(angle[0])

    assert of(0, 0, 1, 1, 1, 0) == pytest.approx((0.001, 0.01), rel=1e-3)
    assert of(1, 0, 0, 0, 0, 1) == pytest.approx((0.003, 0.03), rel=1e-3)
    assert of(1, 1, 1, 1, 1, 1) == pytest.approx((np.hypot(0.003, 0.001), np.hypot(0.01, 0.03)))
    assert np.isnan(of(0, 0, 0, 1, 1, 1)[0])
    assert np.isnan(of(1, 1, 1, 0, 0, 0)[1])


@pytest.mark.parametrize(
    ("weights", "drawn"),
    [
        ((0, 0, 1, 1, 1, 0), ["z [mm]", "error [mm]", "error [mrad]"]),
        pytest.param((1, 0, 1, 0, 0, 0), ["z [mm]", "error [mm]"], marks=pytest.mark.slow),
        pytest.param(
            (0, 0, 0, 1, 1, 1), ["turned since rest [mrad]", "error [mrad]"], marks=pytest.mark.slow
        ),
    ],
)
def test_only_what_has_a_goal_is_drawn(
    weights: tuple[int, ...],
    drawn: list[str],
    actuators: Actuators,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    """The plate of the tripod follows in height and tilt; sideways it goes where these lead it."""
    figures: list[Figure] = []
    monkeypatch.setattr(Figure, "savefig", lambda self, *_, **__: figures.append(self))
    run = replace(run_of("frame", 7), weights=np.array(weights, dtype=float))
    run.goal[:, :3] += np.array([0.02, 0.02, 0.02]) * (1 - np.array(weights[:3]))
    report = make_report(run)
    if sum(weights[:3]):
        assert report.model_error.max_mm is not None and report.model_error.max_mm < 15.0
    else:
        assert report.model_error.rms_mm is None
    draw_run(run, actuators, tmp_path / "run.png")
    labels = [axes.get_ylabel() for axes in figures[0].axes]
    assert [label for label in labels if "[m" in label and "pull" not in label][
        : len(drawn)
    ] == drawn


def test_a_run_that_is_held_from_the_start_says_so_and_is_as_long_as_its_targets() -> None:
    """It follows ten ticks, then no decision can be used any more."""
    run = run_of("point", 3)
    first = run.active.start
    ticks = tuple(
        tick
        if tick.mode is not Mode.RUN or i < first + 10
        else replace(tick, mode=Mode.HOLD, cause=Cause.UNUSABLE, status="INFEASIBLE")
        for i, tick in enumerate(run.ticks)
    )
    whole, report = make_report(run), make_report(replace(run, ticks=ticks))
    assert report.duration_s == whole.duration_s > 1.0
    assert (report.ticks, report.following) == (whole.ticks, 10)
    assert report.hindered.pop("decision not usable") == whole.following - 10
    assert report.hindered == whole.hindered
    report = make_report(replace(run, ticks=ticks))
    rows = dict(table_rows(report))
    assert "decision not usable" in rows["ticks that followed / all"]
    assert report.following < FOLLOWED * report.ticks
    assert "held instead of following" in not_followed(report)


def test_the_figure_starts_where_the_robot_follows(
    actuators: Actuators, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """At the start of a demo the first decisions are late, for longer than the figure is to show."""
    figures: list[Figure] = []
    monkeypatch.setattr(Figure, "savefig", lambda self, *_, **__: figures.append(self))
    run = run_of("point", 3)
    first = run.active.start
    ticks = tuple(
        replace(tick, mode=Mode.HOLD, cause=Cause.LATE) if first <= i < first + 40 else tick
        for i, tick in enumerate(run.ticks)
    )
    for shown, start in ((run, first), (replace(run, ticks=ticks), first + 40)):
        draw_run(shown, actuators, tmp_path / "run.png")
        assert figures[-1].axes[-1].get_xlim()[0] == pytest.approx(run.time[start] - 0.5)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0.00"), (-0.0, "0.00"), (4.1e-5, "4.10e-05"), (0.0123, "0.0123"), (1.0, "1.00"),
        (41.46, "41.5"), (412.3, "412"), (31254.0, "31254"), (-0.5, "-0.500"), (None, "-"),
        (-8.67e-16, "0.00"), (2.0e-9, "2.00e-09"),
    ],
)  # fmt: skip
def test_values_of_small_and_large_robots_have_digits(value: float | None, text: str) -> None:
    assert digits(value) == text


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
    weights = np.ones(COMPONENTS[kind])
    return replace(run, kind=kind, weights=weights, goal=goal, model=model, plant=plant)


@pytest.mark.long
@pytest.mark.parametrize(
    ("kind", "size", "unit"),
    [
        ("frame", 7, "mrad"),
        pytest.param("distance", 1, "mm", marks=pytest.mark.slow),
        ("volume", 1, "ml"),
    ],
)
def test_a_run_of_any_kind_is_reported_and_drawn(
    kind: EffectorKind, size: int, unit: str, actuators: Actuators, tmp_path: Path
) -> None:
    run = run_of(kind, size)
    report = make_report(run)
    row = dict(table_rows(report))["tracking error of the plant, RMS / max"]
    assert row.endswith(unit)
    assert ("mm" in row) == (kind != "volume")
    distance, angle = errors_to_goal(run, run.plant)
    assert np.isfinite(distance).any()
    assert np.isfinite(angle).any() == (kind == "frame")
    draw_run(run, actuators, tmp_path / "run.png")
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


def test_units_of_errors() -> None:
    found = error("frame", np.array([0.003, np.nan]), np.array([0.02, 0.01]))
    assert found.max_mm == pytest.approx(3.0)
    assert found.max_mrad == pytest.approx(20.0)
    assert error("volume", np.array([2e-6]), np.array([np.nan])).max_ml == pytest.approx(2.0)
    assert error("point", np.array([np.nan]), np.array([np.nan])).rms_mm is None
