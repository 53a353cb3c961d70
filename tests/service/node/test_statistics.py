"""Health of the loop: what left and what the model has, where the limiter made them differ."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from prometheus_client.parser import text_string_to_metric_families
from support.effectors import ALL_KINDS, solid
from support.messages import tick_of
from support.robots.bodies import beam_config, beam_robot, box_mesh
from support.robots.examples import shipped_setup

from tauten.controller import Controller
from tauten.model import Simulator
from tauten.model.load import build_robot
from tauten.model.schema import RobotConfig
from tauten.service.node import Action, Clock, ControlLoop, Signals
from tauten.service.node.metrics import prometheus_text
from tauten.service.node.statistics import SURPRISING, LoopStatistics
from tauten.service.wire import (
    Cause,
    Diagnostic,
    Level,
    Mode,
    Rejection,
    RejectionReason,
    Window,
    decode_health,
    encode_health,
)

SIZE = (0.1, 0.02, 0.02)


def efforts(action: Action, loop: ControlLoop) -> Diagnostic:
    robot = loop.controller.robot
    statistics = LoopStatistics(robot.actuators, robot.effector_layout, robot.size)
    statistics.add(tick_of(action), action, action.actuation.effector_values)
    found = statistics.diagnostics(Clock(0.02), [], None, {})
    return next(item for item in found if item.name == "tensions")


def test_health_says_where_the_model_agrees() -> None:
    loop = ControlLoop(Controller(beam_robot(box_mesh(SIZE, (6, 2, 2)), SIZE)))
    action = loop.tick(None, Signals(target=False))
    assert (action.mode, action.cause) == (Mode.IDLE, Cause.NO_TARGET)
    health = efforts(action, loop)
    assert (health.level, health.message) == (Level.OK, "as in the model")


def test_health_counts_ticks_by_mode_and_status_and_has_the_deepest_gap() -> None:
    """Gaps that are open, or that nobody knows, are no depth."""
    loop = ControlLoop(Controller(beam_robot(box_mesh(SIZE, (6, 2, 2)), SIZE), "none"))
    robot, goal = loop.controller.robot, loop.controller.effector_values
    statistics = LoopStatistics(robot.actuators, robot.effector_layout, robot.size)
    for gap in (np.inf, 1e-3, np.nan, -2e-3, -1e-3):
        target = None if gap == np.inf else goal
        action = loop.tick(target, Signals(target is not None))
        loop.prepare()
        status = "" if action.status is None else action.status.name
        tick = replace(tick_of(action), deepest_gap=gap, status=status)
        statistics.add(tick, action, loop.controller.effector_values)
        said = statistics.diagnostics(Clock(0.02), [], None, {})[1]
        depth = 2.0 if gap < 0.0 else 0.0
        assert float(said.values["deepest_penetration_mm"]) == depth
    counts = ("ticks_idle", "ticks_run", "status_OK", "clamped")
    assert [said.values[name] for name in counts] == ["1", "4", "4", "0"]
    assert (said.level, said.message) == (Level.OK, "run, 0 not OK")


def test_health_has_the_tension_that_left_and_the_models() -> None:
    """A hold of the manipulator whose wound tendons would pull with 130 N, where 80 N are allowed."""
    setup = shipped_setup("manipulator")
    simulator = Simulator(setup.robot, "none")
    simulator.settle_start()
    index = setup.robot.actuators.names.index("tendon2a")
    position = np.zeros(setup.robot.n_a)
    position[index] = 9.5e-3
    assert simulator.settle(position=position).converged
    needed = float(simulator.effort[index])
    assert 120.0 < needed < 140.0
    controller = Controller(setup.robot, "none", settings=setup.controller)
    controller.start_from(simulator.state, simulator.forces, simulator.position)
    loop = ControlLoop(controller)
    action = loop.tick(None, Signals(target=False))
    assert action.actuation.effort[index] == 80.0
    assert action.actuation.clamped
    health = efforts(action, loop)
    assert health.level is Level.WARN
    said = re.search(r"tendon2a: 80 N have left, the model has (\d+) N", health.message)
    assert said is not None
    assert float(said[1]) == pytest.approx(needed, rel=0.02)
    assert health.values["tendon2a_n"] == "80"
    assert float(health.values["tendon2a_n_model"]) == pytest.approx(needed, rel=0.02)
    stopped = efforts(replace(action, mode=Mode.STOP), loop)  # it does not move then: no comparison
    assert (stopped.level, stopped.message) == (Level.OK, "released without the model")


def test_cables_of_any_names_have_entries_of_their_own() -> None:
    """Of cables a and a_model the tension of the latter was lost: the model's of the former had its key."""
    config = beam_config(SIZE)
    (cable,) = config["cables"]  # type: ignore[misc]
    config["cables"] = [{**cable, "name": name} for name in ("a", "a_model", "a_n")]
    robot = build_robot(RobotConfig.model_validate(config), box_mesh(SIZE, (6, 2, 2)), "beam")
    loop = ControlLoop(Controller(robot))
    values = efforts(loop.tick(None, Signals(target=False)), loop).values
    assert list(values) == [
        "a_n",
        "a_n_model",
        "a_model_n",
        "a_model_n_model",
        "a_n_n",
        "a_n_n_model",
    ]


def test_a_level_that_does_not_exist_is_refused() -> None:
    payload = bytearray(encode_health(1, "r", [Diagnostic("x", Level.STALE, "", {})]))
    found = decode_health(bytes(payload))
    assert isinstance(found, dict)
    assert found["x"].level is Level.STALE
    place = payload.index(3, 20)  # the level is the first byte of the first status
    payload[place] = 7
    refused = decode_health(bytes(payload))
    assert isinstance(refused, Rejection)
    assert refused.reason is RejectionReason.MALFORMED
    assert refused.detail == "found level 7, allowed are 0, 1, 2, 3"


@pytest.mark.long
def test_health_warns_where_the_model_does_not_go_where_decisions_say() -> None:
    """A swing beyond the winch's rate is predicted; a model that moves beside its predictions is not."""
    loop = ControlLoop(Controller.of("finger"))
    controller = loop.controller
    robot = controller.robot
    cases = [
        (LoopStatistics(robot.actuators, robot.effector_layout, robot.size), beside, warned)
        for beside, warned in ((0.0, False), (2.0 * SURPRISING, True))
    ]
    rest, way = robot.effector_values(robot.rest()), 0.15 * robot.size * np.array([1.0, 0.6, 0.3])
    for k in range(150):
        goal = rest + way * np.sin(2.0 * np.pi * k / 50.0)
        action = loop.tick(goal, Signals(target=True))
        loop.prepare()
        for statistics, beside, _ in cases:
            moved = controller.shifted(beside * robot.size / np.sqrt(3.0))
            statistics.add(tick_of(action), action, moved)
    assert action.decided
    for statistics, _, warned in cases:
        found = statistics.diagnostics(Clock(0.02), [], None, {})
        health = next(item for item in found if item.name == "decisions")
        assert ("away from what decisions predict" in health.message) == warned
        error = float(health.values["prediction_error_mm"])
        assert (error > 1e3 * SURPRISING * robot.size) == warned


@pytest.mark.parametrize("number", range(len(ALL_KINDS)))
def test_every_kind_of_effector_may_move_away_from_what_decisions_say(number: int) -> None:
    """In metres by the units of its rows; a turn, a distance and a volume were not seen."""
    robot = solid([ALL_KINDS[number]])
    loop, layout = ControlLoop(Controller(robot)), robot.effector_layout
    by = layout.row_starts[-1] - 1  # its last row: of a frame a rotation
    found = []
    for metres in (0.0, 3e-3):
        statistics = LoopStatistics(robot.actuators, layout, robot.size)
        for _ in range(2):
            action = loop.tick(loop.controller.effector_values, Signals(target=True))
            predicted, change = action.actuation.effector_values, np.zeros(layout.n_rows)
            change[by] = metres / layout.units[by]
            for _ in range(400):  # forgets the start
                statistics.add(tick_of(action), action, layout.moved(predicted, change))
        health = statistics.diagnostics(Clock(0.02), [], None, {})
        decisions = next(item for item in health if item.name == "decisions")
        found.append(float(decisions.values["prediction_error_mm"]))
    assert found == pytest.approx([0.0, 3.0], abs=0.01)


def test_what_is_left_free_may_move_away_from_what_decisions_say() -> None:
    """Along x and about z, with weight 0: no target was too fast for it, as health said."""
    frame = next(one for one in ALL_KINDS if one.get("kind") == "frame")
    robot = solid([{**frame, "weight": [0.0, 1.0, 1.0, 1.0, 1.0, 0.0]}])
    loop, layout = ControlLoop(Controller(robot)), robot.effector_layout
    statistics = LoopStatistics(robot.actuators, layout, robot.size)
    action = loop.tick(loop.controller.effector_values, Signals(target=True))
    change = np.array([0.03, 0.0, 4e-3, 0.0, 0.0, 0.5])  # m, rad
    for _ in range(400):
        statistics.add(
            tick_of(action), action, layout.moved(action.actuation.effector_values, change)
        )
    health = statistics.diagnostics(Clock(0.02), [], None, {})
    decisions = next(item for item in health if item.name == "decisions")
    assert float(decisions.values["prediction_error_mm"]) == pytest.approx(4.0, abs=0.01)
    assert decisions.values["deepest_penetration_mm"] == "0"  # it was -0


def test_health_says_that_time_ends_decisions() -> None:
    """A robot whose decisions are always cut is slow with usable statuses."""
    loop = ControlLoop(Controller(beam_robot(box_mesh(SIZE, (6, 2, 2)), SIZE)))
    robot = loop.controller.robot
    statistics = LoopStatistics(robot.actuators, robot.effector_layout, robot.size)
    action = loop.tick(loop.controller.effector_values, Signals(target=True))
    said = []
    for checks in (-1, 3):
        for _ in range(40):
            tick = replace(tick_of(action), status="MAX_PIVOTS")
            statistics.add(tick, replace(action, checks=checks), action.actuation.effector_values)
        found = statistics.diagnostics(Clock(0.02), [], None, {})
        said.append(next(item for item in found if item.name == "decisions"))
    assert "out of time" not in said[0].message and said[0].values["cut"] == "0"
    assert (
        "40 of the last 50 decisions ran out of time, so that the robot is late" in said[1].message
    )
    assert "raise service.decision_share" in said[1].message


def test_health_warns_of_time_only_while_it_ends_most_decisions() -> None:
    loop = ControlLoop(Controller(beam_robot(box_mesh(SIZE, (6, 2, 2)), SIZE)))
    robot = loop.controller.robot
    statistics = LoopStatistics(robot.actuators, robot.effector_layout, robot.size)
    action = loop.tick(loop.controller.effector_values, Signals(target=True))
    tick, left = replace(tick_of(action), status="OK"), action.actuation.effector_values
    ended = replace(action, checks=3)
    said = []
    for later in (
        (tick, [action, action, ended]),
        (tick, [ended] * 3),
        (tick_of(action), [action]),
    ):
        for one in later[1]:
            statistics.add(later[0], one, left)
        found = statistics.diagnostics(Clock(0.02), [], None, {})
        said.append(next(item for item in found if item.name == "decisions"))
    assert [one.level for one in said] == [Level.OK, Level.WARN, Level.OK]
    assert [one.values["cut"] for one in said] == ["1", "4", "0"]
    assert "4 of the last 6 decisions ran out of time" in said[1].message
    assert "out of time" not in said[2].message


def test_cables_whose_names_differ_by_case_have_metrics_of_their_own() -> None:
    """Both were `tauten_tensions_left_n`, and Prometheus takes no page with the same metric twice."""
    values = {"Left_n": "1", "left_n": "2", "right_n": "3", "Note": "one", "note": "other"}
    found = [Diagnostic("tensions", Level.OK, "", values)]
    text = prometheus_text("arm", found, {}).decode()
    families = {one.name: one for one in text_string_to_metric_families(text)}
    assert text.count("# TYPE") == len(families)
    numbers = {
        one.documentation: one.samples[0].value
        for one in families.values()
        if one.name.startswith("tauten_tensions_") and one.type == "gauge" and "_n" in one.name
    }
    assert {"tensions: Left_n": 1.0, "tensions: left_n": 2.0, "tensions: right_n": 3.0}.items() <= (
        numbers.items()
    )
    assert families["tauten_tensions_right_n"].samples[0].labels == {"robot": "arm"}
    (info,) = families["tauten_tensions_info"].samples
    assert {"one", "other", "arm"} == set(info.labels.values())


def test_times_in_health_are_of_the_last_1024_values_and_the_largest_of_all() -> None:
    window = Window()
    assert window.entries("lateness_ms", 1e3) == {}
    for value in (3e-4, 1e-4, 2e-4, float("nan")):
        window.add(value)
    expected = {"lateness_ms_p50": "0.2", "lateness_ms_p99": "0.3", "lateness_ms_max": "0.3"}
    assert window.entries("lateness_ms", 1e3) == expected
    for _ in range(1024):
        window.add(1e-4)
    expected = {"lateness_ms_p50": "0.1", "lateness_ms_p99": "0.1", "lateness_ms_max": "0.3"}
    assert window.entries("lateness_ms", 1e3) == expected
