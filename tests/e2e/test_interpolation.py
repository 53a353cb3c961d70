"""A node that follows slow targets on straight lines between them, with a delay that it states."""

from __future__ import annotations

import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.nodes import check_limits, last_health, recorded, whole
from support.processes import ROBOT, Served, write_robot

from tauten.model import load_robot
from tauten.model.numerics import Array
from tauten.service.codec.messages import POSE
from tauten.service.replay import replay
from tauten.service.wire import CDR, EffectorMessage, Mode, encode_effector

DELAY, BETWEEN, SPEED, TURNING = 0.25, 0.1, 1e-3, 0.05  # s, s, m/s, rad/s
TOOL = """\
[[effectors]]
name = "tool"
kind = "frame"
region = { lower = [0.099, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }
"""


@pytest.fixture
def beam_file(tmp_path: Path) -> Path:
    """The small robot with a pose as its only effector."""
    return write_robot(tmp_path, ROBOT.split("[[effectors]]", maxsplit=1)[0] + TOOL)


def pose_at(rest: Array, seconds: float) -> Array:
    """A pose that moves and turns evenly (7,)."""
    x, y, z = rest[:3].tolist()
    turn = Rotation.from_rotvec([0.0, -TURNING * seconds, 0.0])
    return np.array([x, y, z + SPEED * seconds, *np.roll(turn.as_quat(), 1)])


def stream(served: Served, rest: Array, count: int) -> int:
    """Send so many poses, each with the time when it was made; returns the first of these [ns]."""
    begin = time.time_ns()
    for _ in range(count):
        stamp = time.time_ns()
        values = tuple(pose_at(rest, 1e-9 * (stamp - begin)).tolist())
        payload = encode_effector("frame", "tool", EffectorMessage(stamp, "", values))
        served.session.put("tauten/beam/target", payload, encoding=f"{CDR};{POSE}")
        time.sleep(BETWEEN)
    return begin


@pytest.mark.long
@pytest.mark.parametrize(
    "served",
    [("--interpolate", str(DELAY)), pytest.param((), marks=pytest.mark.slow)],
    indirect=True,
)
def test_goals_are_on_the_line_of_the_stamps(
    request: pytest.FixtureRequest, served: Served, beam_file: Path
) -> None:
    robot = load_robot(beam_file)
    delay = DELAY if request.node.callspec.params["served"] else 0.0
    assert last_health(served)["targets"].values["interpolation_delay_s"] == f"{delay:g}"
    begin = stream(served, robot.effector_values(robot.rest()), 18)
    assert served.process.end() == 0
    ticks, joints, _ = recorded(served.log, robot)
    assert whole(ticks)
    check_limits(joints, robot)
    rest = robot.effector_values(robot.rest())
    following = [tick for tick in ticks if tick.mode is Mode.RUN and tick.goal_values]
    following = [tick for tick in following if tick.stamp > begin + 1e9 * (delay + BETWEEN)]
    assert len(following) > 20  # of a busy machine
    off, stairs = [], 0
    for before, tick in pairwise(following):
        goal = np.array(tick.goal_values)
        due = 1e-9 * (tick.stamp - begin) - tick.lateness  # goals are those of when a tick was due
        wanted = pose_at(rest, due - delay)
        turned = Rotation.from_quat(np.roll(goal[3:], -1)).inv() * Rotation.from_quat(
            np.roll(wanted[3:], -1)
        )
        off.append(max(np.linalg.norm(goal[:3] - wanted[:3]) / SPEED, turned.magnitude() / TURNING))
        stairs += tick.goal_values == before.goal_values
    latency = [tick.latency for tick in following if np.isfinite(tick.latency)]
    if delay:
        assert np.median(off) < 0.01  # s; a tick is stamped after its decision
        assert stairs < 0.1 * len(off)
        assert min(latency) >= delay
    else:
        assert np.median(off) > 0.02
        assert stairs > 0.4 * len(off)
        assert min(latency) < BETWEEN
    assert replay(served.log, 1e-4, against=str(beam_file)).same
