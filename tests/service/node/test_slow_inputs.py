"""What arrives for a node whose period is longer than the timeouts of its file; without a network."""

from __future__ import annotations

import time

import numpy as np
import pytest
from support.messages import Point, encode_point
from support.robots.bodies import beam_robot, box_mesh
from support.samples import Sample, Session

from tauten.service.node.inputs import NodeInputs
from tauten.service.settings import ServiceSettings
from tauten.service.wire import Cause, Keys

SIZE = (0.1, 0.02, 0.02)
RATE = 1.2  # Hz


@pytest.mark.parametrize(
    "age", [0.7, 1.6]
)  # s, beyond the timeout: within one period and within two
def test_a_target_that_arrived_since_the_last_ticks_is_followed(age: float) -> None:
    robot = beam_robot(box_mesh(SIZE, (4, 1, 1)), SIZE, controller={"rate": RATE})
    session, settings = Session(), ServiceSettings()
    assert settings.target_timeout < age < 2.0 / RATE
    inputs = NodeInputs(session, robot, settings, False, None)  # type: ignore[arg-type]
    rest = robot.effector_values(robot.rest())
    goal = rest + np.array([0.0, 0.0, 0.01])
    x, y, z = goal.tolist()
    point = Point(time.time_ns() - round(1e9 * age), robot.frame, (x, y, z))
    next(iter(session.samples.values())).append(Sample(encode_point(point)))
    assert inputs.read_targets(0)
    found = inputs.goal(rest)
    assert found is not None
    np.testing.assert_allclose(found.values, goal)


def test_fast_nodes_have_the_timeouts_of_their_file_and_slow_ones_three_periods() -> None:
    settings = ServiceSettings(target_timeout=0.5, measurement_timeout=0.25)
    assert settings.lasting(0.02) == settings
    slow = settings.lasting(0.1)
    assert (slow.target_timeout, slow.measurement_timeout) == pytest.approx((0.5, 0.3))
    assert settings.lasting(2.0).target_timeout == pytest.approx(6.0)


@pytest.mark.parametrize(("age", "cause"), [(12.0, Cause.NONE), (18.0, Cause.UNMEASURED)])  # s
def test_measurements_that_are_always_late_have_the_timeout_beside_their_delay(
    age: float, cause: Cause
) -> None:
    robot = beam_robot(box_mesh(SIZE, (4, 1, 1)), SIZE)
    session = Session()
    settings = ServiceSettings(measurement_timeout=5.0, measurement_delay=10.0)
    inputs = NodeInputs(session, robot, settings, True, None)  # type: ignore[arg-type]
    rest = robot.effector_values(robot.rest())
    x, y, z = rest.tolist()
    (key,) = Keys(robot.name).measurements(robot.effector_names)
    point = Point(time.time_ns() - round(1e9 * age), robot.frame, (x, y, z))
    session.samples[str(key)].append(Sample(encode_point(point)))
    assert inputs.read_measurements(rest, True, 0) is cause


def test_no_effector_is_corrected_whose_target_no_longer_arrives() -> None:
    """It stays where the model has it; the correction would push it away from there."""
    ends = [
        {"name": name, "point": [x, 0.01, 0.01]} for name, x in (("tip", 0.1), ("middle", 0.05))
    ]
    robot = beam_robot(box_mesh(SIZE, (4, 1, 1)), SIZE, effectors=ends)
    session, settings = Session(), ServiceSettings(target_timeout=5.0)
    inputs = NodeInputs(session, robot, settings, True, None)  # type: ignore[arg-type]
    rest, keys = robot.effector_values(robot.rest()), Keys(robot.name)
    for key, x in zip(keys.measurements(robot.effector_names), (0.101, 0.051), strict=True):
        point = Point(0, robot.frame, (x, 0.01, 0.01))
        session.samples[str(key)].append(Sample(encode_point(point)))
    assert inputs.read_measurements(rest, True, 0) is Cause.NONE
    target = Point(0, robot.frame, (0.1, 0.01, 0.012))
    session.samples[str(keys.targets(robot.effector_names)[0])].append(Sample(encode_point(target)))
    assert inputs.read_targets(0)
    goal = inputs.goal(rest)
    assert goal is not None and goal.correction is not None
    assert goal.correction[0] < -1e-4  # measured farther out than the model is
    np.testing.assert_array_equal(goal.correction[3:], 0.0)
    np.testing.assert_array_equal(goal.corrected[3:], rest[3:])
    np.testing.assert_allclose(goal.corrected[:3], [0.1 + goal.correction[0], 0.01, 0.012])
