"""Integral action on top of the model: it removes a constant mismatch and does not wind up."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from support.effectors import END, solid
from support.messages import point_layout

from tauten.model import Robot
from tauten.model.body import natural_frequencies
from tauten.model.numerics import Array
from tauten.service.node import Feedback
from tauten.service.node.estimator import make_estimator, slowest_period
from tauten.service.node.feedback import ModelHistory, stable_gain
from tauten.service.node.plausibility import MeasurementCheck, Swing
from tauten.service.settings import ServiceSettings

H = 0.02
LAYOUT = point_layout(["tip"])
BOTH = point_layout(["tip", "middle"])
OFF = np.array([0.003, 0.0, -0.002])  # the robot is that far from its model


def follow(feedback: Feedback, target: np.ndarray, reach: float, steps: int) -> np.ndarray:
    """A model that reaches goals within a ball at once, a robot that is off; where the robot ends."""
    measured = OFF * 0.0
    for _ in range(steps):
        goal = target + feedback.correction
        model = goal * min(1.0, reach / float(np.linalg.norm(goal)))
        measured = model - OFF
        feedback.update(model, measured, H)
    return measured


def test_a_mismatch_is_removed_at_the_gains_pace() -> None:
    feedback, target = Feedback(LAYOUT, gain=2.0, largest=1.0), np.array([0.01, 0.02, 0.0])
    error = [float(np.linalg.norm(follow(feedback, target, 1.0, 25) - target)) for _ in range(6)]
    # half a second a turn: the error falls by e each
    np.testing.assert_allclose(np.array(error[1:]) / error[:-1], np.exp(-1.0), rtol=1e-9)
    np.testing.assert_allclose(feedback.correction, OFF, rtol=0.01)


def test_a_target_out_of_reach_does_not_wind_it_up() -> None:
    feedback, far = Feedback(LAYOUT, gain=2.0, largest=10.0), np.array([0.3, 0.0, 0.0])
    follow(feedback, far, reach=0.1, steps=5000)
    assert np.linalg.norm(feedback.correction) <= np.linalg.norm(OFF) * (1.0 + 1e-9)
    # so back in reach it is right at once
    near = np.array([0.05, 0.0, 0.0])
    np.testing.assert_allclose(follow(feedback, near, 0.1, 2), near, atol=1e-6)


@given(st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(0.0, 10.0)), max_size=30))
def test_no_correction_is_longer_than_allowed(seen: list[tuple[float, float]]) -> None:
    feedback = Feedback(LAYOUT, gain=5.0, largest=0.02)
    for off, seconds in seen:
        feedback.update(np.full(3, off), np.zeros(3), seconds)
        assert np.linalg.norm(feedback.correction) <= 0.02 * (1.0 + 1e-12)


def test_long_pauses_do_not_overshoot() -> None:
    feedback = Feedback(LAYOUT, gain=50.0, largest=1.0)
    feedback.update(OFF, np.zeros(3), 100.0)
    np.testing.assert_allclose(feedback.correction, OFF)
    feedback.reset()
    assert not feedback.correction.any()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_model_that_is_lost_corrects_nothing(bad: float) -> None:
    feedback = Feedback(LAYOUT, gain=5.0, largest=0.02)
    feedback.update(np.full(3, bad), np.zeros(3), 1.0)
    assert not feedback.correction.any()


def with_delay(feedback: Feedback, delay: float, seconds: float) -> np.ndarray:
    """Error (k,) of a robot unlike its model, whose late measurement is compared with the present model."""
    target, steps = np.array([0.01, 0.02, 0.0]), round(delay / H)
    robot, error = [np.zeros(3)] * (steps + 1), []
    for _ in range(round(seconds / H)):
        model = target + feedback.correction
        robot.append(model - OFF)
        feedback.update(model, robot[-1 - steps], H)
        error.append(float(np.linalg.norm(robot[-1] - target)))
    return np.array(error)


def test_a_late_measurement_is_stable_with_the_gain_of_a_stated_delay() -> None:
    size = float(np.linalg.norm(OFF))
    swinging = with_delay(Feedback(LAYOUT, gain=2.0, largest=0.1), delay=1.0, seconds=40.0)
    assert swinging[-200:].max() > 3.0 * size
    stable = with_delay(Feedback(LAYOUT, gain=2.0, largest=0.1, delay=1.0), delay=1.0, seconds=40.0)
    assert stable[-200:].max() < 0.01 * size


@given(st.floats(1e-3, 100.0), st.floats(1e-3, 10.0))
def test_the_gain_is_below_the_limit_of_the_delay(gain: float, delay: float) -> None:
    assert stable_gain(gain, delay) == pytest.approx(min(gain, pi / (4.0 * delay)))
    assert stable_gain(gain, 0.0) == gain


def swung(feedback: Feedback, omega: float, zeta: float, seconds: float = 6.0) -> Array:
    """Distances from its target (k,) of a robot that swings, every millisecond [m].

    Its model reaches goals at once. The angular frequency is in rad/s, the damping ratio unitless.
    """
    h = 1e-3  # s
    rates = np.array([[0.0, 1.0, 0.0], [-(omega**2), -2.0 * zeta * omega, omega**2], [0, 0, 0]])
    moving, robot, error = expm(h * rates), np.array([0.01, 0.0]), list[float]()
    for _ in range(round(seconds / h)):
        goal = feedback.correction.copy()
        feedback.update(goal, np.array([robot[0], 0.0, 0.0]), h)
        robot = (moving @ [*robot, goal[0]])[:2]
        error.append(abs(float(robot[0])))
    return np.array(error)


@pytest.mark.parametrize("share", [0.7, 1.4])
def test_a_robot_swings_for_ever_where_the_gain_is_more_than_its_damping_bears(
    share: float,
) -> None:
    """s (s² + 2 ζ ω s + ω²) + g ω² has all its roots on the left where g < 2 ζ ω (Routh)."""
    omega, zeta = 2.0 * pi * 3.0, 0.05
    gain = share * 2.0 * zeta * omega
    growth = float(np.roots([1.0, 2.0 * zeta * omega, omega**2, gain * omega**2]).real.max())
    assert (growth > 0.0) is (share > 1.0)
    error = swung(Feedback(LAYOUT, gain, largest=10.0), omega, zeta)
    assert error[5000:].max() / error[2000:3000].max() == pytest.approx(
        np.exp(3.0 * growth), rel=0.1
    )


@pytest.mark.parametrize("ratio", [0.3, 0.6, 0.9, 1.0, 1.2])
def test_the_mean_over_a_period_of_the_model_damps_slower_robots_and_hardly_drives_faster_ones(
    ratio: float,
) -> None:
    """By g sin(ω T) / ω T, to first order in g / ω and ζ; without a mean they swing for ever."""
    period, zeta, gain = 0.3, 0.015, 2.0  # s, 1, 1/s
    omega = ratio * 2.0 * pi / period
    for average in (0.0, period):
        pushed = gain * float(np.sinc(omega * average / pi))
        error = swung(Feedback(LAYOUT, gain, largest=10.0, average=average), omega, zeta)
        growth = np.log(error[5000:].max() / error[2000:3000].max()) / 3.0  # 1/s
        assert growth == pytest.approx(0.5 * (pushed - 2.0 * zeta * omega), abs=0.15)
        assert bool(growth < 0.0) is (average > 0.0 and ratio > 0.5)


def test_a_node_averages_over_the_slowest_vibration_of_its_model(beam: Robot) -> None:
    estimator, settings = make_estimator(beam, ServiceSettings()), ServiceSettings()
    rest = beam.rest()
    period = 1.0 / natural_frequencies(beam.body, rest, 1)[0]
    assert slowest_period(beam) == pytest.approx(period)
    n, model = beam.effector_layout.n_rows, beam.effector_values(rest)
    for away in (1e-3, -1e-3):  # a period before, and for half of it: its mean is zero
        found = estimator.update(model, model + away, 0.5 * period)
    first = 1.0 - np.exp(-0.5 * settings.feedback_gain * period)
    np.testing.assert_allclose(found, np.full(n, -1e-3 * first * (1.0 - first)), rtol=1e-6)


def extent(difference: Callable[[float], list[float]], size: float = 0.3) -> float:
    """By which a robot of some size swings that differs from its model so at a time [m]."""
    swing, model = Swing(LAYOUT, size), np.array([0.1, 0.0, 0.0])
    for tick in range(200):
        swing.add(tick * H, model, model + np.array(difference(tick * H)))
    return swing.extent


def test_a_robot_that_swings_about_its_model_is_told_from_one_that_differs() -> None:
    noise = np.random.default_rng(0)
    swings = 2.0 * pi * 3.0  # rad/s, of which means over 0.1 s are 14 % smaller
    assert extent(lambda t: [0.03 + 0.01 * np.sin(swings * t), 0.0, 0.0]) == pytest.approx(
        0.0172, rel=0.02
    )
    for other in (
        lambda t: [0.003 * np.sin(swings * t), 0.0, 0.0],  # by little
        lambda t: [0.05, 0.0, 0.02 * t],
        lambda t: [0.02 * np.sin(pi * t), 0.02 * np.cos(pi * t), 0.0],  # round a path, at 0.5 Hz
        lambda t: list(1e-3 * noise.standard_normal(3)),
    ):
        assert extent(other) == 0.0


def test_the_model_of_a_moment_ago_is_found() -> None:
    """Between ticks it moves evenly, as the actuators do; each effector is measured at a time of its own."""
    history = ModelHistory(BOTH)
    for tick in range(10):
        history.add(0.1 * tick, np.full(6, float(tick)))
    np.testing.assert_allclose(history.at([0.35, 0.42]), [3.5] * 3 + [4.2] * 3, rtol=1e-12)
    np.testing.assert_allclose(history.at([0.9, 0.83]), [9.0] * 3 + [8.3] * 3, rtol=1e-12)
    assert history.at([1.5, 0.1]) == pytest.approx(
        [9.0] * 3 + [8.0] * 3
    )  # older ones are forgotten


def test_the_model_of_a_moment_ago_turns_evenly_between_ticks() -> None:
    """About z, by 0.8 rad in a tick."""
    history = ModelHistory(FRAME)
    for tick in range(2):
        half = 0.5 * 0.8 * tick
        turned = [0.1 * tick, 0.0, 0.0, np.cos(half), 0.0, 0.0, np.sin(half)]
        history.add(0.02 * tick, np.array(turned))
    found = history.at([0.015])
    wanted = [0.075, 0.0, 0.0, np.cos(0.3), 0.0, 0.0, np.sin(0.3)]
    np.testing.assert_allclose(found, wanted, atol=1e-12)


SIZE = 0.1
REST = np.array([[0.1, 0.0, 0.0], [0.05, 0.0, 0.0]])


def check(measure: object, scale: float = 1.0) -> tuple[MeasurementCheck, list[str]]:
    """What a check finds while the model swings up and down, and measurements are made of it."""
    found, reasons = MeasurementCheck(BOTH, SIZE, 0.25 * SIZE), []
    for tick in range(200):
        up = 0.015 * scale * np.sin(2.0 * pi * tick / 100.0)
        model = REST + np.array([[0.0, 0.0, up], [0.0, 0.0, 0.3 * up]])
        reasons.append(found.reason(model.ravel(), measure(model).ravel(), H))  # type: ignore[operator]
    return found, reasons


def test_a_robot_that_is_unlike_its_model_is_plausible() -> None:
    """Stiffer, softer, displaced, noisy."""
    rng = np.random.default_rng(3)
    for measure in (
        lambda model: REST + 0.5 * (model - REST),
        lambda model: REST + 1.5 * (model - REST),
        lambda model: model + 0.01,
        lambda model: model + 1e-3 * rng.standard_normal((2, 3)),
    ):
        found, reasons = check(measure)
        assert not found.fault
        assert set(reasons) == {""}


def test_a_robot_that_starts_three_ticks_after_its_model_is_plausible() -> None:
    """The model goes 6 % of the robot's size in each of four ticks, as after a target that jumps."""
    found, fault = MeasurementCheck(BOTH, SIZE, 0.5 * SIZE), []
    ways = np.concatenate([np.zeros(10), 0.006 * np.arange(1, 5), np.full(20, 0.024)])
    for tick in range(3, len(ways)):
        model, measured = (REST + ways[at] * np.array([0.0, 0.0, 1.0]) for at in (tick, tick - 3))
        found.reason(model.ravel(), measured.ravel(), H)
        fault.append(found.fault)
    assert set(fault) == {""}


def test_a_measurement_that_stands_still_now_and_then_is_plausible() -> None:
    """As where a robot sticks: without progress twice in a row it is a fault, but not with some between."""
    found, measured, model = MeasurementCheck(BOTH, SIZE, 0.5 * SIZE), REST, REST
    for tick in range(60):
        step = 0.001 * np.array([0.0, 0.0, 1.0 if tick < 30 else -1.0])
        model = model + step
        measured = measured + (step if tick // 6 % 2 else 0.0)
        assert found.reason(model.ravel(), measured.ravel(), H) == ""
    for _ in range(13):
        model = model + 0.001 * np.array([0.0, 0.0, 1.0])
        found.reason(model.ravel(), measured.ravel(), H)
    assert "does not follow" in found.fault


@pytest.mark.parametrize(
    ("measure", "text"),
    [
        (lambda model: REST, "does not follow"),
        (lambda model: REST - (model - REST), "does not follow"),
        (lambda model: REST + (model - REST)[:, [0, 2, 1]], "does not follow"),
        (lambda model: model[::-1], "mm from the model"),
        (lambda model: 1e3 * model, "mm from the model"),
        (lambda model: model + np.nan, "mm from the model"),
    ],
)
def test_a_frozen_mirrored_turned_or_exchanged_measurement_is_not(
    measure: object, text: str
) -> None:
    _, reasons = check(measure)
    assert text in reasons[-1]


def test_effectors_that_are_close_to_each_other_are_found_exchanged() -> None:
    found = MeasurementCheck(BOTH, SIZE, 0.25 * SIZE)
    model = np.array([[0.1, 0.0, 0.0], [0.09, 0.0, 0.0]])
    assert (
        found.reason(model.ravel(), model[::-1].ravel(), H)
        == "two measured effectors are exchanged"
    )


def test_a_single_jump_is_refused_and_the_next_measurement_used() -> None:
    found = MeasurementCheck(BOTH, SIZE, 0.25 * SIZE)
    assert found.reason(REST.ravel(), REST.ravel(), H) == ""
    assert "jumps by 20 mm" in found.reason(
        REST.ravel(), (REST + np.array([0.0, 0.0, 0.02])).ravel(), H
    )
    assert found.reason(REST.ravel(), REST.ravel() + 1e-4, 2.0 * H) == ""
    assert not found.fault


FRAME = solid([{"name": "tool", "kind": "frame", "region": END}]).effector_layout
LENGTH = solid().size


def turned(values: np.ndarray, *turn: float) -> np.ndarray:
    """A pose turned about its own axes [rad]."""
    return FRAME.moved(values, np.array([0.0, 0.0, 0.0, *turn]))


POSE = np.array([0.1, 0.01, 0.01, 1.0, 0.0, 0.0, 0.0])


def test_a_turned_robot_is_corrected_until_it_has_the_targets_rotation() -> None:
    """The robot is turned and displaced against its model; the model reaches every goal."""
    feedback = Feedback(FRAME, gain=2.0, largest=1.0)
    target = turned(POSE, 0.2, -0.3, 0.1)
    measured = POSE
    for _ in range(400):
        model = FRAME.moved(target, feedback.correction)
        measured = FRAME.moved(model, np.array([2e-3, 0.0, -1e-3, 0.05, 0.02, -0.03]))
        feedback.update(model, measured, H)
    np.testing.assert_allclose(FRAME.difference(measured, target), np.zeros(6), atol=1e-6)
    assert np.linalg.norm(feedback.correction[3:]) == pytest.approx(
        np.linalg.norm([0.05, 0.02, -0.03]), rel=0.01
    )


def test_no_correction_of_a_rotation_is_larger_than_allowed() -> None:
    feedback = Feedback(FRAME, gain=50.0, largest=0.25 * LENGTH)
    for _ in range(20):
        feedback.update(turned(POSE, 0.0, 0.0, 1.0), POSE, 1.0)
    assert np.linalg.norm(feedback.correction[3:]) == pytest.approx(0.25)
    assert FRAME.lengths(feedback.correction).max() == pytest.approx(0.25 * LENGTH)
    assert not feedback.correction[:3].any()


def test_a_rotation_that_is_off_jumps_or_does_not_follow_is_not_plausible() -> None:
    found = MeasurementCheck(FRAME, LENGTH, 0.25 * LENGTH)
    assert "mm from the model" in found.reason(POSE, turned(POSE, 0.0, 0.4, 0.0), H)
    assert found.reason(POSE, POSE, H) == ""
    assert "jumps" in found.reason(POSE, turned(POSE, 0.0, 0.2, 0.0), 1e-3)
    assert found.reason(POSE, -POSE * [-1, -1, -1, 1, 1, 1, 1], H) == ""  # the same rotation
    frozen, reasons = MeasurementCheck(FRAME, LENGTH, 0.25 * LENGTH), []
    for tick in range(200):
        model = turned(POSE, 0.0, 0.12 * np.sin(2.0 * pi * tick / 100.0), 0.0)
        reasons.append(frozen.reason(model, POSE, H))
    assert "does not follow" in reasons[-1]
