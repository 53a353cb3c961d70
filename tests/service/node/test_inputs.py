"""What a node does with what arrives for it: counts, records, says in health; without a network."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, field

import numpy as np
import pytest
from support.messages import Point, Sample, Session, encode_point
from support.robots.bodies import beam_robot, box_mesh

from tauten.controller import Controller
from tauten.model import Robot
from tauten.service.log import Entry
from tauten.service.node.inputs import NodeInputs
from tauten.service.settings import ServiceSettings
from tauten.service.wire import (
    JSON,
    Cause,
    EffectorMessage,
    Keys,
    Level,
    OperatorCommand,
    Rejection,
    RejectionReason,
    encode_effector,
)

KEYS, NAMES = Keys("beam"), ("tip", "middle")
SIZE = (0.1, 0.02, 0.02)
RATE = 1.2  # Hz, of a node whose period is longer than the timeouts of its file


@dataclass
class Kept:
    """What is handed to the log."""

    entries: list[Entry] = field(default_factory=list)

    def write(self, entry: Entry) -> None:
        self.entries.append(entry)


class Rig:
    """Inputs of the beam with two effectors, and messages for them."""

    def __init__(self, robot: Robot, closed_loop: bool = False, **settings: float) -> None:
        self.session, self.kept = Session(), Kept()
        self.rest = robot.effector_values(robot.rest())
        self.inputs = NodeInputs(
            self.session, robot, ServiceSettings(**settings), closed_loop, self.kept
        )  # type: ignore[arg-type]

    def send(self, keys: tuple[str, ...], offset: float = 0.0, stamp: int = 0) -> None:
        """A position of each effector, at rest and so far along x [m]."""
        for key, xyz in zip(keys, self.rest.reshape(-1, 3), strict=False):
            x, y, z = xyz.tolist()
            point = Point(stamp, "", (x + offset, y, z))
            self.session.samples[str(key)].append(Sample(encode_point(point)))

    def health(self, name: str) -> tuple[Level, str]:
        (found,) = (one for one in self.inputs.diagnostics() if one.name == name)
        return found.level, found.message


def test_health_names_the_effector_whose_targets_no_longer_arrive(beam: Robot) -> None:
    rig = Rig(beam, target_timeout=0.06)  # three periods, the shortest that counts
    rig.send(KEYS.targets(NAMES))
    assert rig.inputs.read_targets(0)
    assert rig.health("targets")[0] is Level.OK
    time.sleep(0.1)
    rig.send(KEYS.targets(NAMES)[:1])
    assert rig.inputs.read_targets(1)
    level, text = rig.health("targets")
    assert level is Level.WARN
    assert text.startswith("too old: middle; ")


def test_targets_are_recorded_with_their_time_or_that_of_the_tick(beam: Robot) -> None:
    rig, begin = Rig(beam), time.time_ns()
    rig.send(KEYS.targets(NAMES)[:1], stamp=begin)
    rig.inputs.read_targets(3)
    rig.send(KEYS.targets(NAMES)[:1])
    rig.inputs.read_targets(4)
    first, second = rig.kept.entries
    assert {first.key, second.key} == {KEYS.targets(NAMES)[0]}
    assert (first.sequence, second.sequence) == (3, 4)
    assert first.published == begin
    assert begin <= first.logged <= second.published == second.logged <= time.time_ns()


def test_commands_are_recorded_and_read_once_in_their_order(beam: Robot) -> None:
    rig = Rig(beam)
    for word in ("hold", "enable"):
        text = f'{{"data": "{word}"}}'.encode()
        rig.session.samples[KEYS.command].append(Sample(text, JSON))
    found = rig.inputs.read_commands(7)
    assert found == [OperatorCommand.HOLD, OperatorCommand.ENABLE]
    assert rig.inputs.read_commands(8) == []
    assert [(one.key, one.sequence) for one in rig.kept.entries] == [(KEYS.command, 7)] * 2


def test_a_command_that_was_carried_out_is_counted_and_resets_the_correction(beam: Robot) -> None:
    rig = Rig(beam, closed_loop=True)
    for _ in range(2):
        rig.send(KEYS.measurements(NAMES), offset=1e-3)
        assert rig.inputs.read_measurements(rig.rest, True, 0) is Cause.NONE
    rig.send(KEYS.targets(NAMES))
    rig.inputs.read_targets(0)
    goal = rig.inputs.goal(rig.rest)
    assert goal is not None and np.abs(goal.correction).max() > 1e-5
    rig.inputs.count(OperatorCommand.HOLD, None)
    goal = rig.inputs.goal(rig.rest)
    assert goal is not None and np.abs(goal.correction).max() > 1e-5
    rig.inputs.count(OperatorCommand.RESET, None)
    goal = rig.inputs.goal(rig.rest)
    assert goal is not None
    np.testing.assert_array_equal(goal.correction, 0.0)
    assert rig.health("commands") == (Level.OK, "all accepted")
    found = {one.name: one.values for one in rig.inputs.diagnostics()}
    assert found["commands"]["accepted"] == "2"
    assert found["measurements"]["accepted"] == "4"


def test_health_warns_of_a_correction_at_its_limit(beam: Robot) -> None:
    """The robot is about as far from its model as a correction may be long."""
    for share, level, said in (
        (0.9, Level.OK, "plausible"),
        (0.995, Level.WARN, "the correction is at its limit"),
        (1.01, Level.WARN, "an effector is measured 26.2 mm from the model, allowed are 26 mm"),
    ):
        rig = Rig(beam, closed_loop=True, feedback_gain=1e3)
        rig.send(KEYS.measurements(NAMES), offset=0.25 * share * beam.size)
        rig.inputs.read_measurements(rig.rest, True, 0)
        assert rig.health("feedback") == (level, said)


def test_a_refused_command_is_a_line_of_the_log_once_in_a_row(
    beam: Robot, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig, now = Rig(beam), [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    caplog.set_level(logging.WARNING)
    for seconds, why, lines in (
        (0.0, "first", 1), (0.5, "second", 1), (1.0, "second", 1), (2.0, "first", 2),
    ):  # fmt: skip
        now[0] = 100.0 + seconds
        rig.inputs.count(OperatorCommand.ENABLE, Rejection(RejectionReason.NOT_NOW, why))
        assert len(caplog.records) == lines
    assert rig.health("commands") == (Level.WARN, "4 refused, last: first")


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


TABLE = {
    "name": "table",
    "shape": "plane",
    "position": [0.0, 0.0, -0.1],
    "parameters": {"point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]},
    "stream": {"largest_speed": 1.0, "timeout": 0.2},
}


def test_a_slower_model_may_take_over() -> None:
    """At 2 Hz in place of 100: obstacles were those of 10 ms later, and all that arrived was too old."""
    fast, slow = (
        beam_robot(
            box_mesh(SIZE, (4, 1, 1)), SIZE, obstacles=[TABLE],
            contacts=[{"candidates": "below", "against": "table", "points": "vertices"}],
            surfaces=[{"name": "below", "box": {"lower": [0.08, -1, -1], "upper": [1, 1, 1]}}],
            controller={"rate": rate},
        )
        for rate in (100.0, 2.0)
    )  # fmt: skip
    session, kept = Session(), ServiceSettings()
    inputs = NodeInputs(session, fast, kept, False, None, slow.h)  # type: ignore[arg-type]
    controller, keys = Controller(slow, "none"), Keys(fast.name)
    controller.depth_of("table", controller.obstacles.poses[0])  # compiles its kernels
    made = []  # s
    for height in (-0.1, -0.09):
        made.append(time.time() - 0.5)
        pose = (0.0, 0.0, height, 1.0, 0.0, 0.0, 0.0)
        payload = encode_effector(
            "frame", "table", EffectorMessage(round(1e9 * made[-1]), "", pose)
        )
        session.samples[keys.obstacle("table")].append(Sample(payload))
        placed = inputs.read_obstacles(controller)
        time.sleep(0.1)
    expected = -0.09 + 0.01 / (made[1] - made[0]) * (0.5 + slow.h)
    assert placed["table"].position[2] == pytest.approx(expected, abs=0.02)
    x, y, z = fast.effector_values(fast.rest()).tolist()
    point = Point(time.time_ns() - 1_200_000_000, fast.frame, (x, y, z))
    session.samples[keys.targets(fast.effector_names)[0]].append(Sample(encode_point(point)))
    assert inputs.read_targets(0)


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
