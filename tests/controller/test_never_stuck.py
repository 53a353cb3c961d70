"""Whatever locks, sags and least tensions leave behind, decisions go on, within all limits."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize
from support.robots.beam_robots import tendon_arm
from support.robots.bodies import beam_robot, box_mesh
from support.robots.joined import BASE, LINK, linked

import tauten.controller.step
from benchmarks.control.orders import order_run
from tauten.controller import Actuation, Controller, Status
from tauten.model import Robot, Simulator, load_robot
from tauten.model.numerics import Array
from tauten.model.simulation import Travel
from tauten.service.process import StopFlag
from tauten.service.setup import load_setup

SIZE = (0.1, 0.02, 0.02)


def tendon(name: str, height: float, **changes: object) -> dict[str, object]:
    return {
        "name": name,
        "points": [[0.01, 0.01, height], [0.1, 0.01, height]],
        "max_tension": 6.0,
        "max_pull": 0.015,
        "max_rate": 0.05,
        **changes,
    }


def beam(gravity: float = 0.0, **changes: object) -> Robot:
    """A cable below and one above the middle; downwards gravity shortens the path of the lower one."""
    return beam_robot(
        box_mesh(SIZE, (6, 2, 2)),
        SIZE,
        gravity=[0.0, 0.0, gravity],
        cables=[tendon("lower", 0.002, **changes), tendon("upper", 0.018, **changes)],
        integration={"scheme": "implicit-euler", "rayleigh_stiffness": 0.02},
        controller={"rate": 50.0},
    )


def checked(controller: Controller, target: Array, ticks: int) -> list[Actuation]:
    """Follow a target; everything that leaves is within limits and rates."""
    limits, left = controller.robot.limits, controller.position
    found = []
    for _ in range(ticks):
        actuation = controller.step(target)
        assert (actuation.effort >= limits.effort_min).all()
        assert (actuation.effort <= limits.effort_max).all()
        assert (actuation.position >= limits.position_min).all()
        assert (actuation.position <= limits.position_max).all()
        step = limits.rate * controller.robot.h
        assert (np.abs(actuation.position - left) <= step * (1.0 + 1e-9)).all()
        left = actuation.position
        found.append(actuation)
    return found


@pytest.mark.long
def test_a_robot_that_sags_faster_than_its_winch_turns_is_decided_for() -> None:
    """The sag makes the lower path shorter than the winch can follow within a tick."""
    controller = Controller(beam(gravity=-15.0, max_rate=0.005))
    assert controller.settle_start().converged
    delta = controller.robot.rows(controller.state, contacts=False).actuators.delta
    assert delta[0] > 2.0 * 0.005 * 0.02
    up = controller.effector + np.array([0.0, 0.0, 0.002])
    found = checked(controller, up, 150)
    assert all(actuation.status.usable for actuation in found)
    assert abs(controller.effector[0, 2] - up[0, 2]) < 5e-4


def test_a_path_that_sags_shorter_than_its_winch_can_follow_is_in_no_conflict() -> None:
    """Holding leads there too: nothing has to be relaxed for it."""
    controller = Controller(beam(gravity=-15.0, max_rate=0.005))
    assert controller.settle_start().converged
    up = controller.effector + np.array([0.0, 0.0, 0.002])
    assert {actuation.status for actuation in checked(controller, up, 6)} == {Status.OK}


def test_least_tensions_are_wound_up_to() -> None:
    controller = Controller(beam(min_tension=2.0, max_rate=0.01))
    still = controller.effector
    found = checked(controller, still, 60)
    assert all(actuation.status.usable for actuation in found)
    assert found[0].status is Status.RELAXED
    assert found[0].conflict
    assert found[-1].status is Status.OK
    assert (controller.effort >= 2.0 * (1.0 - 1e-6)).all()
    assert (found[-1].needed >= 2.0 * (1.0 - 1e-6)).all()


def test_a_lock_that_would_exceed_a_tension_stops_there() -> None:
    controller = Controller(beam())
    still = controller.effector
    controller.lock("lower", position=0.015)
    found = checked(controller, still, 60)
    assert all(actuation.status.usable for actuation in found)
    assert controller.stalled.tolist() == [True, False]
    assert 1e-3 < controller.position[0] < 0.0149
    assert found[-1].needed[0] == pytest.approx(6.0, rel=1e-3)
    controller.unlock("lower")
    after = checked(controller, still, 60)
    assert all(actuation.status is Status.OK for actuation in after[10:])
    assert np.linalg.norm(controller.effector - still) < 1e-4


@pytest.mark.long
def test_after_random_locks_holds_and_targets_decisions_go_on() -> None:
    rng = np.random.default_rng(7)
    controller = Controller(beam(gravity=-5.0))
    controller.settle_start()
    tip, names = controller.effector, controller.robot.actuators.names
    for _ in range(25):
        name = names[rng.integers(2)]
        choice = rng.integers(4)
        if choice == 0:
            controller.lock(name, position=float(rng.uniform(0.0, 0.015)))
        elif choice == 1:
            controller.lock(name, force=float(rng.uniform(0.0, 6.0)))
        elif choice == 2:
            for _ in range(3):
                controller.hold()
                controller.advance()
        checked(controller, tip + rng.normal(size=3) * 0.01, int(rng.integers(1, 6)))
    for i in np.flatnonzero(controller.locks.by_position | controller.locks.by_force).tolist():
        controller.unlock(names[i])
    found = checked(controller, tip, 80)[-30:]
    assert all(actuation.status is Status.OK for actuation in found)
    limits = controller.robot.limits
    assert (found[-1].needed <= limits.effort_max * (1.0 + 1e-6)).all()
    assert np.linalg.norm(controller.effector - tip) < 1e-4


def test_a_hold_reports_what_leaves_and_what_is_needed_apart() -> None:
    simulator = Simulator(beam(), "none")
    assert simulator.settle(position=[0.01, 0.0]).converged
    needed = float(simulator.effort[0])
    controller = Controller(beam(max_tension=0.8 * needed))
    controller.start_from(simulator.state, simulator.forces, simulator.position)
    held = controller.hold()
    assert held.status is Status.INFEASIBLE
    assert held.clamped
    assert held.effort[0] == pytest.approx(0.8 * needed)
    assert held.needed[0] == pytest.approx(needed, rel=1e-3)


def test_a_step_of_second_order_that_diverges_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    controller = Controller(beam())
    target = controller.effector + np.array([0.0, 0.0, 0.005])
    checked(controller, target, 3)
    usual = tauten.controller.step.travel

    def diverging(*arguments: Any) -> Travel:
        moved = usual(*arguments)
        return replace(moved, state=replace(moved.state, v=1e6 * moved.state.v))

    with monkeypatch.context() as patch:
        patch.setattr(tauten.controller.step, "travel", diverging)
        checked(controller, target, 5)
    assert controller.robot.displacement(controller.state, 0.02 * controller.state.v) < 0.01
    assert all(actuation.status is Status.OK for actuation in checked(controller, target, 60)[-5:])
    assert abs(controller.effector[0, 2] - target[0, 2]) < 1e-3


@pytest.mark.slow
def test_a_tripod_is_not_stuck_after_random_orders() -> None:
    """One of these orders lets it snap over; the model diverged there, and did not come back."""
    found = order_run(load_setup("tripod"), 400, 0, StopFlag())
    assert found.stuck == 0
    assert found.beyond == 0.0


def test_a_tick_of_two_seconds_is_usable() -> None:
    """The gripper's tangent over such a step once ended in an error of the factorisation."""
    robot = load_robot("gripper", rate=0.5)
    controller = Controller(robot, "none")
    goal = robot.effector(robot.rest()) + np.array([0.0, 0.0, 1e-3])
    for _ in range(3):
        decided = controller.step(goal)
        assert decided.status.usable
        assert (decided.effort <= robot.limits.effort_max * (1.0 + 1e-9)).all()


@pytest.mark.long
def test_a_winch_that_hardly_turns_beside_a_fast_one_stays_within_limits() -> None:
    robot = load_robot("accordion")
    rate = np.ones(robot.n_a)
    rate[0] = 1e-9
    slow = replace(robot, limits=replace(robot.limits, rate=rate))
    controller = Controller(slow, "none")
    goal = robot.effector(robot.rest()) + 0.2 * robot.size * np.array([1.0, 0.5, 0.0])
    for _ in range(8):
        decided = controller.step(goal)
        assert decided.status.usable
        assert (decided.effort <= robot.limits.effort_max * (1.0 + 1e-9)).all()


def test_a_model_goes_on_where_its_steps_have_no_factor(tmp_path: Path) -> None:
    """An arm that swings met such a step, and stood still in mid-air from then on, with status OK."""
    file = tendon_arm(tmp_path, 12.0)
    damped = "[integration]\nrayleigh_mass = 5.0\n"
    file.write_text(file.read_text(encoding="utf-8") + damped, encoding="utf-8")
    controller = Controller.of(str(file))
    before = controller.tip
    for _ in range(30):
        actuation = controller.step([0.05, -0.02, 0.3955])
        fast = np.abs(controller.state.v).max()  # m/s, rad/s
        assert fast < 0.1 or not actuation.status.ok or not np.array_equal(controller.tip, before)
        before = controller.tip


@pytest.mark.long
def test_cables_that_a_hold_would_tear_do_not_shorten_ways() -> None:
    """Of two on one hinge, wound a little too far in one tick: a turntable stopped at a third of its way."""
    turntable = {
        "name": "turntable", "region": {"kind": "all", "body": "base"}, "axis": [0.0, 0.0, 1.0],
        "through": [0.0, 0.005, 0.005], "max_angle": 0.8, "max_torque": 1.0, "max_rate": 2.0,
    }  # fmt: skip
    robot = linked(
        1, {"min_pull": -0.002, "max_pull": 0.002}, drives=[turntable], gravity=[0.0, 0.0, -9.81],
        integration={"rayleigh_mass": 2.0},
    )  # fmt: skip
    controller, goal = Controller(robot, "none"), np.array([0.024, -0.083, 0.009])
    assert controller.settle_start().converged
    for _ in range(50):
        actuation = controller.step(goal)

    def distance(angles: Array) -> float:
        turn, hinge = angles
        radius, height = BASE + LINK * np.cos(hinge), 0.005 - LINK * np.sin(hinge)
        tip = [radius * np.cos(turn), 0.005 + radius * np.sin(turn), height]
        return float(np.linalg.norm(tip - goal))

    best = minimize(distance, [0.0, 0.0], bounds=[(-0.8, 0.8), (-0.5, 0.5)])
    assert actuation.position[-1] == pytest.approx(best.x[0], abs=1e-6)
    assert np.linalg.norm(controller.tip - goal) == pytest.approx(best.fun, rel=1e-4)


def sprung_links(links: int) -> Controller:
    """Links that two tendons with springs hold on each hinge, in the equilibrium under their weight."""
    spring = {"spring": {"stiffness": 2000.0, "pretension": 1.0}}
    robot = linked(
        links, {"min_pull": -0.004, "max_pull": 0.004, **spring}, gravity=[0.0, 0.0, -9.81],
        integration={"rayleigh_mass": 2.0},
    )  # fmt: skip
    controller = Controller(robot, "none")
    assert controller.settle_start().converged
    return controller


@pytest.mark.long
def test_links_rest_nearest_to_a_target_out_of_reach_that_trembles() -> None:
    """By 10 µm: each tick had another target, plans jumped for ever, and the tip came 20 mm from there."""
    controller, random = sprung_links(2), np.random.default_rng(0)
    goal, distances = controller.tip + np.array([-0.01, 0.0, 0.06]), []
    for _ in range(150):
        controller.step(goal + 1e-5 * random.standard_normal(3))
        distances.append(np.linalg.norm(controller.tip - goal))
    nearest = np.linalg.norm(goal - [BASE, 0.005, 0.005]) - 2.0 * LINK
    np.testing.assert_allclose(distances[-60:], nearest, atol=5e-5)


@pytest.mark.long
@pytest.mark.parametrize(("links", "raised"), [(1, -0.01), (2, 0.01)])
def test_links_that_only_springs_hold_come_to_rest(links: int, raised: float) -> None:
    """Their vibrations, lightly damped, were those of a body that nothing holds: they swung for seconds."""
    controller = sprung_links(links)
    goal, tips = controller.tip + np.array([0.0, 0.0, raised]), []
    for _ in range(150):
        controller.step(goal)
        tips.append(controller.tip)
    assert np.ptp(tips[-40:], axis=0).max() < 1e-8
    nearest = (
        0.0 if links > 1 else np.linalg.norm(goal - [BASE, 0.005, 0.005]) - LINK
    )  # of its circle
    assert np.linalg.norm(controller.tip - goal) == pytest.approx(nearest, abs=5e-6)
