"""Inverse tasks for effectors of every kind: reached, weighed, or said to be out of reach."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.effectors import hollow_mesh
from support.robots.bodies import beam_robot, box_mesh
from support.robots.small_bodies import END as DRIVEN_END
from support.robots.small_bodies import TURN, constrained

from tauten.controller import Controller, ControllerSettings, Status
from tauten.controller.damping import TICK, Dampings
from tauten.model import Cluster, Clusters, Pose, Robot, Simulator
from tauten.model.load import make_robot, robot_path
from tauten.model.numerics import Array
from tauten.model.schema import Changes, read_toml
from tauten.model.signals import EffectorLayout

SIZE = (0.2, 0.02, 0.02)
END = {"lower": [0.195, -1.0, -1.0], "upper": [1.0, 1.0, 1.0]}
TOOL = {"name": "tool", "kind": "frame", "region": END}
PRECISE = ControllerSettings(qp_solver="daqp", regularisation=1e-6, basis=None, max_pivots=100)
SIDES = {"left": (0.0, 0.01), "right": (0.02, 0.01), "top": (0.01, 0.02), "bottom": (0.01, 0.0)}


def trunk(*effectors: dict[str, Any], **changes: object) -> Robot:
    """A beam with cables along all four sides, to its middle and to its end."""
    cables = [
        {
            "name": f"{side}_{name}",
            "points": [[0.0, y, z], [0.5 * reach, y, z], [reach, y, z]],
            "max_tension": 50.0,
            "min_pull": -0.1,
            "max_pull": 0.1,
            "max_rate": 10.0,
        }
        for side, (y, z) in SIDES.items()
        for name, reach in (("near", 0.1), ("far", 0.2))
    ]
    scheme = {"scheme": "quasi-static"}
    settings = {"cables": cables, "effectors": list(effectors), "integration": scheme} | changes
    return beam_robot(box_mesh(SIZE, (10, 2, 2)), SIZE, **settings)


def values_under(robot: Robot, effort: Array) -> Array:
    """Goal values at the equilibrium under some tensions."""
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(effort=effort).converged
    return simulator.effector_values


def efforts(robot: Robot, seed: int) -> Array:
    return np.random.default_rng(seed).uniform(0.0, 6.0, robot.n_a)


def errors(robot: Robot, goal: Array, steps: int = 40) -> tuple[Array, Controller]:
    """Errors (n_e,) after some steps towards a goal, and the controller."""
    controller = Controller(robot, settings=PRECISE)
    for _ in range(steps):
        assert controller.step(goal).status.usable
    return robot.effector_layout.difference(controller.effector_values, goal), controller


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_position_and_pointing_are_reached_with_free_roll(seed: int) -> None:
    """The robot cannot roll; with the roll about its own axis x left free a target that does is reached."""
    robot = trunk({**TOOL, "weight": [1.0, 1.0, 1.0, 0.0, 1.0, 1.0]})
    goal = values_under(robot, efforts(robot, seed))
    layout = robot.effector_layout
    assert np.linalg.norm(layout.difference(goal, robot.effector_values(robot.rest()))[4:]) > 0.05
    found, _ = errors(robot, goal)
    assert np.linalg.norm(found[:3]) < 2e-5
    assert np.linalg.norm(found[3:]) < 2e-3
    rolled = layout.moved(goal, np.array([0.0, 0.0, 0.0, 0.7, 0.0, 0.0]))
    found, _ = errors(robot, rolled)
    assert np.linalg.norm(found[:3]) < 2e-5
    assert np.linalg.norm(found[4:]) < 2e-3
    assert abs(found[3]) > 0.6


def test_orientation_alone_is_reached() -> None:
    robot = trunk({**TOOL, "weight": [0.0, 0.0, 0.0, 0.0, 1.0, 1.0]})
    goal = values_under(robot, efforts(robot, 3))
    found, _ = errors(robot, goal)
    assert np.linalg.norm(found[4:]) < 1e-3
    assert np.linalg.norm(found[:3]) > 1e-4


def test_a_quaternion_and_its_negative_decide_the_same() -> None:
    robot = trunk(TOOL)
    goal = values_under(robot, efforts(robot, 1))
    position = (float(goal[0]), float(goal[1]), float(goal[2]))
    decided = []
    for sign in (1.0, -1.0):
        w, x, y, z = (sign * goal[3:]).tolist()
        controller = Controller(robot, settings=PRECISE)
        decided.append(controller.step(Pose(position, (w, x, y, z))).effort)
    np.testing.assert_array_equal(decided[0], decided[1])


def test_targets_that_pass_half_a_turn_are_followed_without_a_jump() -> None:
    """From one state, decisions for neighbouring targets around half a turn away are nearly the same."""
    robot = trunk(TOOL)
    rest = robot.effector_values(robot.rest())
    angles = np.pi + np.array([-0.02, -0.01, -1e-9, 0.0, 1e-9, 0.01, 0.02])
    decided = []
    for angle in angles:
        controller = Controller(robot, settings=PRECISE)
        goal = np.concatenate([rest[:3], [np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)]])
        actuation = controller.step(goal)
        assert actuation.status is Status.OK
        decided.append(actuation.position)
    changes = np.abs(np.diff(decided, axis=0)).max(axis=1)
    assert changes.max() < 5e-3  # of the 0.1 m that a winch may pull
    assert changes[2:4].max() < 1e-6


def test_a_distance_and_a_length_are_reached() -> None:
    robot = trunk(
        {"name": "span", "kind": "distance", "point": [0.0, 0.0, 0.0], "other": [0.2, 0.02, 0.02]},
        {
            "name": "sensor",
            "kind": "length",
            "points": [[0.0, 0.02, 0.01], [0.1, 0.02, 0.01], [0.2, 0.02, 0.01]],
        },
    )
    goal = values_under(robot, efforts(robot, 4))
    assert np.abs(goal - robot.effector_values(robot.rest())).min() > 5e-4
    found, _ = errors(robot, goal)
    assert np.abs(found).max() < 1e-6


def test_the_volume_of_a_cavity_is_reached() -> None:
    size = (0.1, 0.02, 0.02)
    room = {"name": "room", "kind": "volume", "inside": [0.05, 0.01, 0.01]}
    robot = beam_robot(
        hollow_mesh(), size, effectors=[room], integration={"scheme": "quasi-static"}
    )
    rest = robot.effector_values(robot.rest())
    goal = values_under(robot, np.array([5.0]))
    assert rest[0] == pytest.approx(6e-6)
    assert abs(goal[0] / rest[0] - 1.0) > 1e-3
    found, _ = errors(robot, goal)
    assert abs(found[0]) < 1e-5 * rest[0]


def test_a_weight_moves_the_error_to_the_other_effector() -> None:
    """Two points that cannot both be reached: the one with more weight comes nearer."""
    tip = {"name": "tip", "point": [0.2, 0.01, 0.01]}
    middle = {"name": "middle", "point": [0.1, 0.01, 0.01]}
    shifted = np.array([[0.2, 0.03, 0.01], [0.1, -0.01, 0.01]])
    distances = []
    for weight in (0.1, 1.0, 10.0):
        robot = trunk({**tip, "weight": weight}, middle)
        controller = Controller(robot, settings=PRECISE)
        for _ in range(20):
            controller.step(shifted)
        distances.append(np.linalg.norm(controller.effector - shifted, axis=1))
    tips, middles = np.array(distances).T
    assert tips[0] > 2.0 * tips[1] > 4.0 * tips[2]
    assert middles[0] < middles[1] < middles[2]


def test_weights_and_units_have_no_scale() -> None:
    """A robot twice as large, a target twice as far: the same pull relative to the size."""
    relative = []
    for factor in (1.0, 2.0):
        size = tuple(factor * side for side in SIZE)
        cable = {
            "name": "tendon",
            "points": [[0.0, size[1] / 2, 0.0], [size[0], size[1] / 2, 0.0]],
            "max_tension": 1e4,
            "max_pull": size[0],
            "max_rate": 1e3,
        }
        frame = {
            "name": "tool",
            "kind": "frame",
            "region": {"lower": [0.99 * size[0], -1.0, -1.0], "upper": [1.0, 1.0, 1.0]},
        }
        robot = beam_robot(
            box_mesh(size, (10, 2, 2)), size, cables=[cable], effectors=[frame],
            integration={"scheme": "quasi-static"},
        )  # fmt: skip
        goal = robot.effector_layout.moved(
            robot.effector_values(robot.rest()),
            np.array([0.0, 0.0, -0.02 * factor, 0.0, 0.3, 0.0]),
        )
        controller = Controller(robot, settings=PRECISE)
        for _ in range(10):
            controller.step(goal)
        relative.append(controller.position / size[0])
    np.testing.assert_allclose(relative[0], relative[1], rtol=1e-6)


def test_exact_reaches_what_the_energy_would_hold_back() -> None:
    goals, found = {}, {}
    settings = ControllerSettings(qp_solver="daqp", regularisation=0.1, basis=None, max_pivots=100)
    for exact in (False, True):
        robot = trunk({"name": "tip", "point": [0.2, 0.01, 0.01], "exact": exact})
        goals[exact] = values_under(robot, efforts(robot, 5))
        controller = Controller(robot, settings=settings)
        statuses = [controller.step(goals[exact]).status for _ in range(30)]
        found[exact] = float(np.linalg.norm(controller.effector_values - goals[exact]))
        assert statuses[-1] is Status.OK
    assert found[True] < 1e-7
    assert found[False] > 1e-4


def test_an_exact_target_out_of_reach_is_named_and_approached() -> None:
    robot = trunk({"name": "tip", "point": [0.2, 0.01, 0.01], "exact": True})
    rest = robot.effector_values(robot.rest())
    target = rest + np.array([0.1, 0.0, 0.0])
    controller = Controller(robot, settings=PRECISE)
    actuation = controller.step(target)
    assert actuation.status is Status.NOT_EXACT
    assert actuation.status.usable
    assert not actuation.status.ok
    assert "x of effector tip" in actuation.conflict
    assert "nearest" in actuation.status.value
    nearest = Controller(trunk({"name": "tip", "point": [0.2, 0.01, 0.01]}), settings=PRECISE).step(
        target
    )
    np.testing.assert_allclose(actuation.effort, nearest.effort, atol=1e-9)
    assert controller.step(rest).status is Status.OK


def test_what_an_exact_target_out_of_reach_leaves_is_for_the_others() -> None:
    """Also where these have components that are left free."""
    tip = {"name": "tip", "point": [0.2, 0.01, 0.01], "weight": [0.0, 1.0, 0.0], "exact": True}
    middle = {"name": "middle", "point": [0.1, 0.01, 0.01], "weight": [0.0, 0.0, 1.0]}
    robot = trunk(tip, middle)
    goal = robot.effector_values(robot.rest()) + np.array([0.0, 0.3, 0.0, 0.0, 0.0, -0.002])
    found, controller = errors(robot, goal)
    assert controller.status is Status.NOT_EXACT
    assert abs(found[1]) > 0.05
    assert abs(found[5]) < 1e-3  # half of the way; it is bent by 6 mm where it does not count


def test_an_exact_orientation_names_its_component() -> None:
    robot = trunk({**TOOL, "weight": [0.0, 0.0, 0.0, 1.0, 1.0, 1.0], "exact": True})
    rest = robot.effector_values(robot.rest())
    rolled = robot.effector_layout.moved(rest, np.array([0.0, 0.0, 0.0, 0.5, 0.0, 0.0]))
    actuation = Controller(robot, settings=PRECISE).step(rolled)
    assert actuation.status is Status.NOT_EXACT
    assert "rotation about x of effector tool" in actuation.conflict


def test_a_wrong_goal_holds() -> None:
    robot = trunk(TOOL)
    controller = Controller(robot, settings=PRECISE)
    for target in ([np.nan] * 7, [0.2, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0]):
        actuation = controller.step(target)
        assert actuation.status is Status.NOT_FINITE
        np.testing.assert_array_equal(actuation.position, np.zeros(robot.n_a))


def test_a_goal_of_another_kind_is_refused() -> None:
    controller = Controller(trunk(TOOL), settings=PRECISE)
    with pytest.raises(
        ValueError, match=r"found shape \(3,\), expected a Pose for tool, or shape \(7,\)"
    ):
        controller.step([0.2, 0.0, 0.0])


def test_predicted_values_are_those_of_the_next_state(tmp_path: Path) -> None:
    robot = trunk(TOOL, {"name": "tip", "point": [0.2, 0.01, 0.01]})
    goal = values_under(robot, 0.2 * efforts(robot, 1))
    controller = Controller(robot, settings=PRECISE)
    for _ in range(10):
        actuation = controller.step(goal)
    np.testing.assert_allclose(actuation.effector_values, controller.effector_values, atol=1e-7)
    np.testing.assert_allclose(actuation.effector, controller.effector, atol=1e-7)


def test_the_frame_of_a_driven_region_turns_with_its_motor() -> None:
    """A servo turns the end of a beam, rigid and about a fixed axis: its frame has the servo's angle."""
    effector = {"name": "tool", "kind": "frame", "region": DRIVEN_END}
    weight = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    robot = constrained(
        cables=None,
        drives=[{**TURN, "region": DRIVEN_END}],
        effectors=[{**effector, "weight": weight}],
        integration={"scheme": "quasi-static"},
    )
    layout, rest = robot.effector_layout, robot.effector_values(robot.rest())
    goal = layout.moved(rest, np.array([0.0, 0.0, 0.0, 0.0, 0.4, 0.0]))
    controller = Controller(robot, settings=PRECISE)
    for _ in range(20):
        assert controller.step(goal).status.usable
    found = layout.difference(controller.effector_values, rest)
    np.testing.assert_allclose(found[3:], [0.0, 0.4, 0.0], atol=1e-4)
    assert controller.position == pytest.approx([0.4], abs=1e-4)


@pytest.mark.long
def test_the_manipulator_reaches_a_position_and_points() -> None:
    """Nine tendons for three coordinates and two angles; the roll about the tool's axis z is free."""
    path = robot_path("manipulator")
    contents = read_toml(path)
    contents["effectors"][0] |= {"kind": "frame", "weight": [1.0, 1.0, 1.0, 1.0, 1.0, 0.0]}
    contents["integration"] |= {"scheme": "quasi-static"}
    robot = make_robot(contents, path, Changes())
    layout, rest = robot.effector_layout, robot.effector_values(robot.rest())
    effort = np.zeros(9)
    effort[[0, 4, 8]] = 8.0, 5.0, 6.0
    goal = values_under(robot, effort)
    turned = layout.difference(goal, rest)
    assert np.linalg.norm(turned[:3]) > 0.05
    assert np.linalg.norm(turned[3:5]) > 0.1
    found, _ = errors(robot, goal, steps=120)
    assert np.linalg.norm(found[:3]) < 1e-3 * robot.size
    assert np.linalg.norm(found[3:5]) < 2e-3


@pytest.mark.long
@pytest.mark.parametrize("scheme", [{"scheme": "quasi-static"}, {"rayleigh_stiffness": 0.02}])
def test_an_exact_target_is_reached_against_what_the_others_want(scheme: dict[str, Any]) -> None:
    """Another effector that weighs more does not hold the exact one where a step does not get there.

    A controller that decides one tick ahead never got there with inertia: NOT_EXACT for ever, 23 mm away.
    """
    tip = {"name": "tip", "point": [0.2, 0.01, 0.01], "exact": True}
    middle = {"name": "middle", "point": [0.1, 0.01, 0.01], "weight": 10.0}
    robot = trunk(tip, middle, integration=scheme)
    goal, rest = values_under(robot, efforts(robot, 5)), robot.effector_values(robot.rest())
    goal[3:] = rest[3:]
    controller = Controller(robot, settings=PRECISE)
    for _ in range(100):
        actuation = controller.step(goal)
        assert actuation.status.usable
    assert actuation.status is Status.OK
    assert np.linalg.norm(controller.effector_values[:3] - goal[:3]) < 1e-6


@pytest.mark.long
def test_a_target_in_a_component_that_is_left_free_changes_no_decision() -> None:
    """Where it changed it was taken for another target, to which actuators go all of the way at first."""
    path = robot_path("gripper")
    contents = read_toml(path)
    for effector in contents["effectors"]:
        effector["weight"] = [0.0, 1.0, 1.0]
    robot = make_robot(contents, path, Changes())
    quiet, other = Controller(robot), Controller(robot)
    goal = quiet.effector_values + np.tile([0.0, 0.003, -0.002], 3)
    for tick in range(30):
        position = quiet.step(goal).position
        elsewhere = goal + np.tile([0.01 * (tick % 3), 0.0, 0.0], 3)
        np.testing.assert_array_equal(other.step(elsewhere).position, position)


def test_a_volume_that_changes_by_much_is_another_target() -> None:
    """1e-6 m³ of a cavity of 8e-6 m³ were less than 1e-4 of the size in metres."""
    none = np.zeros(1, np.bool_)
    cavity = EffectorLayout(
        ("air",), ("volume",), np.ones(1), np.array([8e-6 ** (-2.0 / 3.0)]), none
    )
    one, no = np.zeros(1, np.int64), np.zeros(0, np.int64)
    clusters = Clusters((Cluster(one, one, no, one),), one, no, no, no, one == 0)
    now, limits = np.array([8e-6]), (0.1, TICK, cavity, False)
    start = Dampings.at_start(clusters).towards(now, *limits)
    held = replace(start, each=(replace(start.each[0], share=0.1),))
    assert held.towards(now + 1e-10, *limits).each[0].share == 0.1
    assert held.towards(np.array([9e-6]), *limits).each[0].share == 1.0
