"""The loop with right and wrong measurements of a simulated robot: in logical time, without a network."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from support.messages import Point, Ring, Sample, encode_point

from tauten.controller import Controller
from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.service.node import LARGEST, ControlLoop, Signals
from tauten.service.node.inputs import MeasuredLoop
from tauten.service.settings import ServiceSettings
from tauten.service.wire import Cause, EffectorSubscriber, Level, Mode, OperatorCommand

Measure = Callable[[Array], Array]


class Rig:
    """A controller, the robot it is the model of, and measurements that are made of that robot."""

    def __init__(self, robot: Robot, measure: Measure) -> None:
        self.loop = ControlLoop(Controller(robot))
        self.plant = Simulator(robot, contact="none")
        self.rings = [Ring() for _ in robot.effector_names]
        layout, rest = robot.effector_layout, robot.effector_values(robot.rest())
        subscriber = EffectorSubscriber(self.rings, robot.frame, layout, rest, 1.0, timeout=0.25)
        self.measured = MeasuredLoop(robot, ServiceSettings(), subscriber)
        self.largest = 0.0  # correction [m]
        self.farthest = 0.0  # robot from its target [m]
        self._measure = measure
        self._now = 0.0

    def follow(self, targets: list[Array]) -> list[Cause]:
        """Follow targets; the cause of each tick."""
        return [self.tick(target) for target in targets]

    def tick(self, target: Array) -> Cause:
        loop, measured = self.loop, self.measured
        self._now += loop.controller.robot.h
        for ring, xyz in zip(self.rings, self._measure(self.plant.effector).tolist(), strict=True):
            ring.samples.append(Sample(encode_point(Point(0, "", tuple(xyz)))))
        measured.subscriber.read(self._now, 1.8e9)
        cause = measured.correct(self._now, loop.controller.effector_values)
        action = loop.tick(target.ravel() + measured.correction, Signals(True, measurement=cause))
        self.plant.step(position=action.actuation.position)
        loop.prepare()
        lengths = loop.controller.robot.effector_layout.lengths(measured.correction)
        self.largest = max(self.largest, float(lengths.max()))
        away = float(np.linalg.norm(self.plant.effector - target, axis=1).max())
        self.farthest = max(self.farthest, away)
        return action.cause


def swing(robot: Robot, ticks: int) -> list[Array]:
    """Targets up and down, where the cables can take the effectors."""
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(position=[0.0, 0.006]).converged
    rest, up = robot.effector(robot.rest()), simulator.effector
    phases = 2.0 * np.pi * np.arange(ticks) / 150.0
    return [rest + np.sin(phase) ** 2 * (up - rest) for phase in phases]


def test_right_measurements_are_followed(beam: Robot) -> None:
    rig = Rig(beam, lambda where: where + 1e-3)
    causes = rig.follow(swing(beam, 150))
    assert set(causes) == {Cause.NONE}
    assert rig.measured.diagnostic().level is Level.OK


@pytest.mark.long
@pytest.mark.parametrize("wrong", ["frozen", "mirrored", "exchanged"])
def test_wrong_measurements_hold_before_the_correction_is_at_its_limit(
    beam: Robot, wrong: str
) -> None:
    rest = beam.effector(beam.rest())
    measures: dict[str, Measure] = {
        "frozen": lambda where: rest,
        "mirrored": lambda where: 2.0 * rest - where,
        "exchanged": lambda where: where[::-1],
    }
    rig = Rig(beam, measures[wrong])
    causes = rig.follow(swing(beam, 100))
    assert causes[-1] is Cause.IMPLAUSIBLE
    assert rig.largest < 0.8 * LARGEST * beam.size
    health = rig.measured.diagnostic()
    assert health.level is Level.WARN
    assert health.message != "plausible"
    assert {"correction_mm", "largest_correction_mm", "age_s", "gain"} <= set(health.values)
    assert rig.measured.subscriber.counts.refused["not_plausible"] > 10


@pytest.mark.long
def test_an_enable_tries_again(beam: Robot) -> None:
    rest, mirrored = beam.effector(beam.rest()), True
    rig = Rig(beam, lambda where: 2.0 * rest - where if mirrored else where)
    targets = swing(beam, 100)
    assert rig.follow(targets)[-1] is Cause.IMPLAUSIBLE
    mirrored = False
    assert rig.follow(targets[:50])[-1] is Cause.IMPLAUSIBLE  # the fault is kept without motion
    assert rig.loop.command(OperatorCommand.ENABLE)
    rig.measured.after_command(OperatorCommand.ENABLE)
    assert set(rig.follow(targets)[50:]) == {Cause.NONE}
    assert rig.loop.state.mode is Mode.RUN


class Late:
    """A measured loop on its own, with the model and the measurements moved from rest along x [m]."""

    def __init__(self, robot: Robot, settings: ServiceSettings) -> None:
        self.rest = robot.effector_values(robot.rest())
        self.rings = [Ring() for _ in robot.effector_names]
        subscriber = EffectorSubscriber(
            self.rings, robot.frame, robot.effector_layout, self.rest, 1.0, timeout=10.0
        )
        self.loop = MeasuredLoop(robot, settings, subscriber)

    def send(self, measured: float) -> None:
        """A measurement of each effector, moved along x [m]."""
        seen = self.rest.reshape(-1, 3) + np.array([measured, 0.0, 0.0])
        for ring, xyz in zip(self.rings, seen, strict=True):
            ring.samples.append(Sample(encode_point(Point(0, "", tuple(xyz.tolist())))))

    def correction(self, now: float, model: float, measured: float) -> Array:
        """Of a measurement that arrives now [s], along x: one of each effector [m]."""
        along = np.tile([1.0, 0.0, 0.0], len(self.rings))
        self.send(measured)
        self.loop.subscriber.read(now, 1.8e9)
        assert self.loop.correct(now, self.rest + model * along) is Cause.NONE
        return self.loop.correction[::3]


def test_a_late_measurement_is_compared_with_the_model_of_its_time(beam: Robot) -> None:
    """A robot that moves as its model does needs no correction, however late that is seen."""
    late, speed = Late(beam, ServiceSettings(measurement_delay=0.1)), 0.05  # m/s
    for tick in range(60):
        now = 0.02 * tick
        found = late.correction(now, speed * now, speed * max(now - 0.1, 0.0))
        assert np.abs(found).max() < 0.3 * speed * 0.1


@pytest.mark.parametrize(
    ("phase", "apart"), [(0.0, 0.0), (0.015, 0.0), (0.0, 0.009), (0.018, 0.013)]
)
def test_a_robot_that_is_like_its_model_needs_no_correction_whenever_it_is_measured(
    beam: Robot, phase: float, apart: float
) -> None:
    """At 50 mm/s; compared with the model of the tick before, 15 ms were a correction of 0.75 mm."""
    late, speed, wall = Late(beam, ServiceSettings()), 0.05, 1.8e9
    rest, along = late.rest, np.array([1.0, 0.0, 0.0])
    for tick in range(40):
        now = 0.02 * tick
        for number, ring in enumerate(late.rings):
            made = now - 0.04 + phase + apart * number
            xyz = rest[3 * number : 3 * number + 3] + speed * max(made, 0.0) * along
            point = Point(round(1e9 * (wall + made)), "", tuple(xyz.tolist()))
            ring.samples.append(Sample(encode_point(point)))
        late.loop.subscriber.read(now, wall + now)
        model = rest + speed * now * np.tile(along, len(late.rings))
        assert late.loop.correct(now, model) is Cause.NONE
        assert np.abs(late.loop.correction).max() < 1e-7


def test_a_correction_after_a_pause_counts_the_timeout_and_not_the_pause(beam: Robot) -> None:
    """dc/dt = g (x_e − x_m − c) over the time between two measurements, or the timeout."""
    settings = ServiceSettings(measurement_timeout=0.25, feedback_gain=2.0)
    late, expected = Late(beam, settings), 0.0
    for now, seconds in ((0.0, 0.25), (0.1, 0.1), (5.0, 0.25)):
        expected += (1.0 - np.exp(-2.0 * seconds)) * (-1e-3 - expected)
        found = late.correction(now, 0.0, 1e-3)
        np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_measurements_hold_the_robot_once_they_have_not_been_plausible_for_the_timeout(
    beam: Robot,
) -> None:
    """They jump by two sizes of the robot; what is plausible again is followed at once."""
    late, found = Late(beam, ServiceSettings(measurement_timeout=0.25)), []
    for tick in range(30):
        away = 0.2 if 5 <= tick < 25 else 0.0
        late.send(away)
        late.loop.subscriber.read(0.02 * tick, 1.8e9)
        found.append(late.loop.correct(0.02 * tick, late.rest))
    assert found == [Cause.NONE] * 17 + [Cause.IMPLAUSIBLE] * 8 + [Cause.NONE] * 5
    assert late.loop.subscriber.counts.refused["not_plausible"] == 20


def test_health_warns_of_a_robot_that_swings_about_its_model(beam: Robot) -> None:
    late = Late(beam, ServiceSettings())
    side = 0.03 * beam.size  # m
    for tick in range(100):
        late.correction(0.02 * tick, 0.0, side * np.sin(2.0 * np.pi * 3.0 * 0.02 * tick))
    health = late.loop.diagnostic()
    assert health.level is Level.WARN
    assert health.message.startswith("the robot swings about its model by ")
    extent = 2e3 * np.sqrt(len(late.rings)) * side  # mm, of which means over 0.1 s have 0.86
    assert float(health.message.split()[7]) == pytest.approx(0.86 * extent, rel=0.05)
    late.loop.after_command(OperatorCommand.RESET)
    assert late.loop.diagnostic().level is Level.OK
