"""A target that moves is followed without delay; the robot comes to rest at one that stays."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.robots.beam_robots import tendon_arm
from support.robots.bodies import pneumatic_robot
from support.robots.examples import shipped_setup

from tauten.controller import Controller
from tauten.controller.planning import (
    largest_share,
    meets_contact,
    shares_that_go_on,
    time_behind,
    with_goal,
)
from tauten.model import (
    Clusters,
    EffectorLayout,
    Robot,
    Simulator,
    clusters_of,
    condense_step,
    no_forces,
)
from tauten.model.numerics import Array
from tauten.service.bench.following import reach_targets, rms
from tauten.service.setup import load_setup

TICKS = 10
STEP = np.array([1e-4, 0.0, -2e-4])  # m, of a target in a tick


def after(goals: list[Array]) -> Array:
    """The course after these goals."""
    course = np.zeros((0, 0))
    for goal in goals:
        course = with_goal(course, goal, TICKS)
    return course


@cache
def layout() -> EffectorLayout:
    """Of a robot with one point."""
    return pneumatic_robot().effector_layout


@cache
def clusters() -> Clusters:
    """Of the same."""
    return clusters_of(pneumatic_robot())


def share(course: Array, moved: Array, late: float = 0.0, most: float = 1.0) -> float:
    """The share that goes on of effectors that are late by some ticks of their motion."""
    values = np.zeros(3) if len(course) == 0 else course[-1] - late * moved
    return float(shares_that_go_on(course, layout(), values, moved, clusters(), most)[0])


def test_motion_goes_on_where_targets_move_as_the_effectors_do() -> None:
    ramp = after([number * STEP for number in range(30)])
    assert len(ramp) == 1 + TICKS // 2
    assert share(ramp, STEP) == share(ramp, 1.5 * STEP) == 1.0
    assert share(ramp, 4.0 * STEP) == pytest.approx(0.5)
    assert share(ramp, -STEP) == share(ramp, np.array([0.0, 1e-4, 0.0])) == 0.0
    assert share(ramp, np.zeros(3)) == 0.0


def test_motion_does_not_go_on_where_targets_stay_or_there_are_none() -> None:
    for goals in ([STEP] * 30, [0.0 * STEP] * 20 + [100.0 * STEP] * 10, [STEP], []):
        assert share(after(goals), STEP) == 0.0
    ramp = after([number * STEP for number in range(30)])
    assert len(with_goal(ramp, None, TICKS)) == 0
    assert share(with_goal(with_goal(ramp, None, TICKS), STEP, TICKS), STEP) == 0.0


def test_motion_does_not_go_on_of_a_robot_that_cannot_follow() -> None:
    ramp = after([number * STEP for number in range(30)])
    assert share(ramp, STEP, late=2.9) == share(ramp, STEP, late=-2.9) == 1.0
    assert share(ramp, STEP, late=3.5) == pytest.approx(0.5)
    assert share(ramp, STEP, late=4.1) == 0.0


def test_less_motion_goes_on_where_damping_is_strong() -> None:
    assert largest_share(0.02, 0.2, 0.0) == largest_share(0.02, 0.2, 0.02) == 1.0
    assert largest_share(0.02, 0.2, 0.1) == pytest.approx(1.0 / 3.0)
    assert largest_share(0.02, 0.2, 0.1, 0.6) == pytest.approx(0.2)
    assert share(after([number * STEP for number in range(30)]), STEP, most=0.3) == 0.3


def test_how_far_effectors_are_behind_targets_is_told_by_the_slower_half_of_the_course() -> None:
    """At constant speed it is the distance over it; where targets stay or jump it is infinite."""
    h, steps = 0.02, np.arange(8.0)[:, None]
    late = after(list(steps * STEP))[-1] - 2.5 * STEP
    assert time_behind(after(list(steps * STEP)), layout(), late, h) == pytest.approx(2.5 * h)
    slower = after([*(2.0 * steps[:5] * STEP), *((8.0 + steps[1:4]) * STEP)])
    assert time_behind(slower, layout(), slower[-1] - STEP, h) == pytest.approx(h)
    jumped = after([0.0 * STEP] * 4 + [100.0 * STEP] * 2)
    for course in (jumped, after([STEP] * 6), after([STEP, 2.0 * STEP]), after([])):
        assert time_behind(course, layout(), np.zeros(3), h) == np.inf


@pytest.mark.long
def test_an_arm_with_ribs_in_contact_follows_without_the_delay_of_the_horizon() -> None:
    """A tip at 60 mm/s is 1.4 mm late, of 8.4 over the whole horizon, and no tension jumps.

    Before plans counted only on firm tangents, tensions jumped by 33 N from one tick to the next.
    """
    setup = shipped_setup("manipulator_1290")
    robot, speed, tensions = setup.robot, 0.06, list[Array]()
    simulator = Simulator(robot, setup.contact)
    simulator.settle_start()
    load = 0.45 * robot.limits.effort_max * np.array([1.0, 0.0, 0.0] * 3)
    assert simulator.settle(effort=load).converged
    controller = Controller(robot, setup.contact, settings=setup.controller)
    controller.start_from(simulator.state, simulator.forces, simulator.position)
    x, y, z = simulator.effector[0].tolist()
    radius, begin, late = np.hypot(x, y), np.arctan2(y, x), list[float]()
    for tick in range(60):
        angle = begin + speed * robot.h * tick / radius
        target = np.array([[radius * np.cos(angle), radius * np.sin(angle), z]])
        tensions.append(controller.step(target).effort)
        late.append(float(np.linalg.norm(controller.effector - target)))
        assert (controller.lam_c > 0.0).any()
    assert rms(late[25:]) < 0.04 * speed
    assert np.abs(np.diff(tensions, axis=0))[25:].max() < 3.0


@pytest.mark.long
def test_an_arm_far_from_contact_follows_fast_targets_with_even_tensions() -> None:
    """Along a line at 120 mm/s: where motion went on, tensions jumped between zero and the largest ones.

    Turned by a third of a circle, which maps tendons to tendons, the targets need the same tensions.
    """
    setup, found = shipped_setup("manipulator_1290"), list[Array]()
    robot, speed = setup.robot, 0.12
    for turn in (0, 1):
        angle = 2.0 * np.pi * turn / 3.0
        R = np.array(
            [[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0, 0, 1]]
        )
        controller = Controller(robot, "none", settings=setup.controller)
        assert controller.settle_start().converged
        way = R @ np.array([0.962, 0.192, 0.192])  # of length one
        target, tensions = controller.effector, list[Array]()
        for tick in range(60):
            target = target + speed * robot.h * way
            tensions.append(controller.step(target).effort)
            late = np.linalg.norm(controller.effector - target)
            assert tick < 20 or late < 0.03 * speed
        jumps = np.abs(np.diff(tensions, axis=0)).max(axis=1)
        assert np.median(jumps) < 1.0
        thirds = np.array(tensions).reshape(-1, 3, 3)  # of each section a, b, c
        found.append(np.roll(thirds, -turn, axis=2))
    np.testing.assert_allclose(found[1], found[0], atol=0.05)


@pytest.mark.long
@pytest.mark.parametrize("disc", [False, True])
def test_a_slender_arm_goes_round_a_circle_with_its_tendons(tmp_path: Path, disc: bool) -> None:
    """Where it can be, at 0.19 m/s: its tip was up to 77 mm away, and its winches turned to and fro.

    Plans counted on stress that an arm has within a tick, as if that pushed in one direction for a horizon;
    those of an arm with a rigid body also on the curvature of its tendons.
    """
    path = tendon_arm(tmp_path, tension=20.0, disc=disc)
    path.write_text(f"{path.read_text()}[integration]\nrayleigh_stiffness = 0.01\n")
    setup, length, turn = load_setup(path), 0.4, 2.0  # m, s
    controller = Controller(setup.robot, setup.contact, settings=setup.controller)
    controller.settle_start()
    late, positions = list[float](), list[Array]()
    for tick in range(1, 111):
        bend, angle = 0.3 * min(tick / 50, 1.0), 2.0 * np.pi * tick * setup.robot.h / turn
        away = (1.0 - np.cos(bend)) * np.array([np.cos(angle), np.sin(angle)])
        target = length / bend * np.array([*away, np.sin(bend)])  # the end of an arc
        positions.append(controller.step(target).position)
        late.append(float(np.linalg.norm(controller.tip - target)))
    changes = np.diff(positions, n=2, axis=0)[50:]  # m in a tick, of what is pulled in a tick
    assert max(late[60:]) < 1e-3
    assert np.abs(changes).max() < 0.1 * setup.robot.h * setup.robot.limits.rate.min()


@pytest.mark.parametrize("reduced", [False, True])
def test_a_share_of_the_way_is_between_all_and_none_of_it(reduced: bool) -> None:
    """v_free is linear in the share a of the way that counts as made: b = h (f − C v − (1 − a) h K v)."""
    robot: Robot = shipped_setup("trunk").robot if reduced else pneumatic_robot()
    state = robot.rest()
    state = replace(state, v=1e-2 * np.random.default_rng(0).standard_normal(robot.n))
    found = [
        robot.linearise(state, None, replace(robot.integration, ahead=share)).v_free.copy()
        for share in (0.0, 0.25, 1.0)
    ]
    none, some, most = found
    np.testing.assert_allclose(some, 0.75 * none + 0.25 * most, rtol=1e-9, atol=1e-12)
    assert np.linalg.norm(most - none) > 0.1 * np.linalg.norm(none)


@pytest.mark.long
def test_a_body_under_pressure_follows_without_the_delay_of_the_horizon_and_stops() -> None:
    """What moves its tip is the damping's slow answer to the pressure: it was late by half of its way."""
    robot = pneumatic_robot(
        integration={"rayleigh_stiffness": 0.1}, controller={"rate": 50.0}, gravity=[0.0, 0.0, 0.0]
    )
    simulator = Simulator(robot, "none")
    assert simulator.settle(effort=[2e4]).converged
    controller, end = Controller(robot), simulator.effector[0]
    start = controller.effector[0]
    speed = (end - start) / 100  # m in a tick
    for number in range(1, 61):
        goal = start + speed * number
        controller.step(goal)
    late = float((goal - controller.effector[0]) @ speed / (speed @ speed))  # ticks
    assert abs(late) < 0.7
    farthest = 0.0
    for _ in range(50):
        controller.step(goal)
        beyond = float((controller.effector[0] - goal) @ speed / (speed @ speed))
        farthest = max(farthest, beyond)
    assert farthest < 1.5  # ticks
    assert np.linalg.norm(controller.effector[0] - goal) < 0.3 * np.linalg.norm(speed)


@pytest.mark.long
@pytest.mark.parametrize(
    ("rate", "period", "error", "roughness"),
    [
        pytest.param(50.0, 10.0, 5e-5, 2.5, marks=pytest.mark.slow),
        (50.0, 6.0, 5e-5, 6.0),
        (100.0, 6.0, 1e-4, 3.0),
    ],
)
def test_bellows_follow_a_path_smoothly(
    rate: float, period: float, error: float, roughness: float
) -> None:
    """Linearised a tick ago, and stopped by folds in range, the tip was 0.25 and 0.5 mm from its path.

    Its pressure alternated by 130 and 350 Pa (RMS of the second difference). At 100 Hz, where its horizon is
    four ticks, the tip was 0.32 mm away, and pressures alternated by 370 Pa where that bound nothing. A first
    target 0.26 mm from the start alone made them alternate by 35 and 50 Pa.
    """
    setup = load_setup("pneumatic_finger", rate=rate)
    robot = setup.robot
    controller = Controller(robot, setup.contact, settings=setup.controller)
    controller.settle_start()
    distances, efforts = list[float](), list[float]()
    targets = reach_targets(robot, period, 0.8)
    for target in targets[: len(targets) // 2]:  # half of the period
        efforts.append(controller.step(target).effort[0])
        distances.append(robot.effector_layout.error(controller.effector_values, target))
    assert rms(np.array(distances)) < error
    assert rms(np.diff(efforts, n=2)) < roughness


@pytest.mark.long
def test_tensions_are_smooth_where_notches_close() -> None:
    """Less than half of 0.34 mN (RMS of the second difference), as decisions over one tick had it.

    With steps as long as the tick, in which notches close, tensions alternated by 0.45 mN.
    """
    setup = shipped_setup("finger")
    controller = Controller(setup.robot, setup.contact, settings=setup.controller)
    controller.settle_start()
    tensions, touching = list[float](), list[bool]()
    for target in reach_targets(setup.robot, 10.0, 0.8):
        tensions.append(controller.step(target).effort[0])
        touching.append(bool((controller.lam_c > 0.0).any()))
    assert any(touching)
    assert not all(touching)
    assert rms(np.diff(tensions, n=2)) < 1.7e-4


def test_contacts_that_do_not_close_leave_motion_as_it_is() -> None:
    setup = shipped_setup("pneumatic_finger")
    robot, space = setup.robot, Controller(setup.robot, setup.contact).space
    state = robot.rest()
    forces = no_forces(robot.n_a, space.k)
    step = condense_step(robot, space, state, forces, contacts=True, effectors=True)
    gaps = step.rows.contacts.rows.delta
    nearest = float(gaps.min())
    assert len(gaps) > 0
    assert nearest > robot.tolerance
    assert not meets_contact(step, forces, 0.04, robot.tolerance)
    assert meets_contact(step, forces, 0.04, 1.1 * nearest)
    H = step.rows.contacts.rows.chosen(np.array([int(gaps.argmin())]))[0]  # (n,)
    closing = replace(step, state=replace(state, v=-(nearest / 0.03) * H / (H @ H)))
    assert meets_contact(closing, forces, 0.04, robot.tolerance)
    assert not meets_contact(closing, forces, 0.01, robot.tolerance)


def test_the_sign_of_no_tension_does_not_choose_the_next_plan() -> None:
    """A plan that leaves a cable at no tension leaves rounding there, as large as that of the others."""
    controller = Controller.of("trunk")
    target = controller.shifted(0.002)
    controller.step(target)
    state, forces, left = controller.state, controller.forces, controller.position
    slack = forces.effort <= 1e-12
    assert slack.any()
    found = []
    for rounding in (0.0, 1e-16):
        there = replace(forces, effort=np.where(slack, rounding, forces.effort))
        controller.start_from(state, there, left)
        found.append(controller.step(target).position)
    np.testing.assert_allclose(found[1], found[0], rtol=0.0, atol=1e-9)
