"""The benchmark of rest: what counts as rest and as the best place, and a small run."""

from __future__ import annotations

import os
import signal
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.control import StillBench, StillRun, StillSettings, bench_still
from benchmarks.control.orders import OrderRun
from benchmarks.control.still import random_goals
from benchmarks.plots import draw_still
from benchmarks.tables import still_page
from tauten.model import load_robot
from tauten.service.process import StopFlag, host_info, stop_on_signals

RUN = StillRun(
    "arm", "reduced", "open", False, 20.0, 1e-8, 1e-8, 5.0, 5.0, ("OK",), 0.3, 0.3, 100.0
)


def test_rest_and_the_best_place_have_limits() -> None:
    assert RUN.rests and RUN.is_best
    assert not replace(RUN, position=1e-5).rests
    assert not replace(RUN, effort=1e-5).rests
    assert not replace(RUN, error_mm=5.2).is_best
    held_back = replace(RUN, error_mm=0.01, best_mm=0.0)  # by a thousandth of the way
    assert held_back.is_near and not held_back.is_best
    assert replace(RUN, error_mm=9.0, best_mm=None).is_best


def test_a_result_goes_into_a_page_and_a_figure(tmp_path: Path) -> None:
    robots = ("finger", "trunk", "diamond", "gripper", "tripod")
    settings = StillSettings(robots, minutes=2.5)
    runs = tuple(replace(RUN, robot=robot) for robot in robots)
    orders = (OrderRun("finger", 400, 0, 0, 0.0, 0.0),)
    result = StillBench(host_info(), settings, runs, orders, True)
    page = tmp_path / "page.md"
    page.write_text(
        "before\n<!-- python -m benchmarks still -->\n<!-- end -->\nafter\n", encoding="utf-8"
    )
    still_page(result).put_into(page)
    text = page.read_text(encoding="utf-8")
    assert text.startswith("before") and text.endswith("after\n")
    assert all(f"| {robot} | reduced | open |" in text for robot in robots)
    for shown in (result, replace(result, runs=())):
        draw_still(shown, tmp_path / "still.png")
    assert (tmp_path / "still.png").stat().st_size > 0


def test_ctrl_c_ends_a_run_that_is_not_done(beam_file: Path) -> None:
    """It was heard only after the run, of up to a quarter of a minute in closed loop."""
    settings = StillSettings((str(beam_file),), ("full",), targets=1, seconds=600.0)
    with stop_on_signals() as stop:
        interrupt = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
        interrupt.start()
        result = bench_still(settings, stop, lambda share, what: None)
    interrupt.join()
    assert not result.complete
    assert (result.runs, result.orders) == ((), ())


@pytest.mark.slow
def test_the_diamond_rests_and_is_never_stuck() -> None:
    settings = StillSettings(("diamond",), ("reduced",), targets=2, orders=40, seconds=6.0)
    result = bench_still(settings, StopFlag(), lambda share, what: None)
    assert result.complete
    assert [run.loop for run in result.runs] == ["open"] * 2 + ["closed"] * 2
    assert all(run.rests and run.is_near for run in result.runs)
    assert all(run.rest_s is not None and run.rest_s < 2.0 for run in result.runs[:2])
    assert all(run.own_rest_s is not None and run.own_rest_s < 2.0 for run in result.runs[:2])
    assert all(run.own_rest_s is None for run in result.runs[2:])
    assert result.orders[0].stuck == 0
    assert result.orders[0].beyond == 0.0
    assert len(still_page(result).tables) == 2


@pytest.mark.slow
def test_goals_repeat_with_the_seed() -> None:
    robot = load_robot("diamond")
    first, again = (list(random_goals(robot, np.random.default_rng(1), 2)) for _ in range(2))
    np.testing.assert_array_equal(first, again)
