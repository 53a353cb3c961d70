"""`tauten bench closed-loop`: a path in reach, and what the distance of model and plant consists of."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.processes import ROBOT, run_main, write_robot

from tauten.controller import Controller
from tauten.model import Robot, Simulator
from tauten.service.bench import bench_closed_loop, closed_loop, follow
from tauten.service.plant import DrivenRobot, PathError
from tauten.service.process import Interrupted, StopFlag
from tauten.service.setup import load_setup
from tauten.service.tables import closed_loop_page

LENGTH = 0.1


def one_effector(folder: Path) -> Path:
    """The file of the test robot with its first effector: the path is for one."""
    return write_robot(folder, ROBOT[: ROBOT.rindex("[[effectors]]")])


@pytest.mark.long
def test_a_run_is_deterministic(beam: Robot) -> None:
    start = beam.effector_values(beam.rest())
    targets = start + 0.002 * np.linspace(0.0, 1.0, 60)[:, None] * np.eye(6)[0]
    traces = [
        follow(Controller(beam), DrivenRobot(Simulator(beam, "none"), 1), targets, closed=True)
        for _ in range(2)
    ]
    np.testing.assert_array_equal(traces[0].effector, traces[1].effector)
    np.testing.assert_array_equal(traces[0].position, traces[1].position)


@pytest.mark.long
def test_a_path_in_reach_is_followed_and_the_distance_of_model_and_plant_divided(
    tmp_path: Path,
) -> None:
    """Of a full model without contact nothing but time is apart, and that share is the whole distance."""
    setup, shares = load_setup(one_effector(tmp_path)), []
    result = bench_closed_loop(setup, (1.0,), StopFlag(), lambda x, what="": shares.append(x))
    assert result.complete
    assert sum(shares) == pytest.approx(1.0)
    (found,) = result.following
    assert found.unusable == 0
    assert found.reduction.max_mm < 1e-6
    assert found.apart.max_mm == pytest.approx(found.time.max_mm, abs=1e-6)
    assert 0.0 < found.time.rms_mm < found.time.max_mm < 0.05 * 1e3 * LENGTH
    assert abs(found.target.rms_mm - found.own.rms_mm) <= found.apart.rms_mm
    page = closed_loop_page(result)
    assert [len(table.rows) for table in page.tables] == [1]
    assert "unknown, run tauten check" in page.about
    assert page.command == f"tauten bench closed-loop {setup.robot.name}"


@pytest.mark.long
def test_a_stopped_benchmark_keeps_what_is_done(tmp_path: Path) -> None:
    setup, stop = load_setup(one_effector(tmp_path)), StopFlag()

    def progress(share: float, what: str = "") -> None:
        if share > 0.0:
            stop.request()

    result = bench_closed_loop(setup, (1.0, 2.0), stop, progress)
    assert not result.complete
    assert [one.period_s for one in result.following] == [1.0]


@pytest.mark.long
def test_a_request_to_stop_ends_the_run_that_is_under_way(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was done to its end, for minutes where a path of full order takes so long."""
    setup, stop, runs = load_setup(one_effector(tmp_path)), StopFlag(), []
    follow_path = closed_loop.follow_path

    def stopped(*arguments: Any) -> closed_loop.Following:
        runs.append(follow_path(*arguments))
        if len(runs) == 2:
            stop.request()
        return runs[-1]

    monkeypatch.setattr(closed_loop, "follow_path", stopped)
    result = bench_closed_loop(setup, (0.2, 0.4, 0.6), stop, lambda share, what="": None)
    assert not result.complete
    assert [one.period_s for one in result.following] == [0.2]


def test_a_stop_before_a_run_is_done_is_said_by_the_exit_code(
    beam_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: object) -> None:
        raise Interrupted

    monkeypatch.setattr("tauten.service.bench.bench_closed_loop", stopped)
    assert run_main("bench", "closed-loop", beam_file) == 130


def test_a_robot_with_several_effectors_is_refused(beam_file: Path) -> None:
    with pytest.raises(PathError, match="has 2 effectors"):
        bench_closed_loop(load_setup(beam_file), (1.0,), StopFlag(), lambda share, what="": None)
