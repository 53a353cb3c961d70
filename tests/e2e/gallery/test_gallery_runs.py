"""Robots of the gallery served over real Zenoh in closed loop: followed, recorded and replayed.

Targets are those that the actuators reach, one mirrored through the base, which only the height of the
tripod's plate reaches, and one far above it, which none does.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from tauten.model import load_robot
from tauten.service.plant import DemoResult, DemoSettings, run_demo
from tauten.service.plant.demo import LOG
from tauten.service.process import StopFlag
from tauten.service.replay import replay

pytestmark = [pytest.mark.slow]
ROBOTS = ("trunk", "pneumatic_finger", "tripod")


def run(name: str, folder: Path, path: str, seconds: float) -> DemoResult:
    """A closed-loop run along a path."""
    settings = DemoSettings(
        name, folder, seconds=seconds, path=path, period=seconds, fraction=0.5, closed_loop=True
    )
    return run_demo(settings, StopFlag(), lambda text: None)


def check_limits(name: str, done: DemoResult) -> None:
    """All that was sent is within the limits of the robot file."""
    limits, slack = load_robot(name).limits, 1.0 + 1e-6
    position, effort = done.run.position.value, done.run.effort.value
    assert len(position) > 2.0 * done.report.rate_hz  # a demo runs at the rate that can be held
    assert (position <= slack * limits.position_max).all()
    assert (position >= slack * limits.position_min).all()
    assert (effort <= slack * limits.effort_max).all()
    assert (effort >= slack * limits.effort_min).all()


@pytest.mark.realtime
@pytest.mark.parametrize("name", ROBOTS)
def test_what_can_be_reached_is_followed_and_replays(name: str, tmp_path: Path) -> None:
    # in 4 s the tensions of the trunk's cables reach their limits
    done = run(name, tmp_path / "run", "reach", 12.0)
    check_limits(name, done)
    assert done.report.model_error is not None
    assert done.report.model_error.rms_mm < 1e3 * 0.03 * load_robot(name).size
    assert replay(tmp_path / "run" / LOG, tolerance=1e-6, recorded_paths=True).same


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("way", ["inverted", "unreachable"])
def test_what_cannot_be_reached_is_approached_within_limits(
    name: str, way: str, tmp_path: Path
) -> None:
    robot = load_robot(name)
    goal = robot.effector_values(robot.rest())[robot.effector_layout.values_of(0)].copy()
    if way == "inverted":
        goal[:3] *= -1.0
    else:
        goal[:3] += 0.9 * robot.size * np.array([0.0, 0.0, 1.0])
    columns = ["x", "y", "z", "qw", "qx", "qy", "qz"][: len(goal)]
    file = tmp_path / "far.csv"
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(["t", *columns])
        writer.writerows([[t, *goal.tolist()] for t in (0.0, 4.0)])
    done = run(name, tmp_path / "run", str(file), 4.0)
    check_limits(name, done)
    wanted = done.run.weighted[:3]
    off = np.linalg.norm((done.run.plant.value[:, :3] - goal[:3])[:, wanted], axis=1)
    assert off.min() < off[0] - 0.03 * robot.size
    assert replay(tmp_path / "run" / LOG, tolerance=1e-6, recorded_paths=True).same
