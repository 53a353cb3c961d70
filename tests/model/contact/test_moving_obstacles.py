"""Obstacles in poses that change: paths, velocities, and what they do to a robot."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.robots.blocks import block, force_on
from support.robots.small_bodies import small_body

from tauten.controller import Controller
from tauten.model import Robot, RobotFileError, Simulator, contact_wrenches
from tauten.model.contact import ObstaclePath, ObstaclePoses, pose_at, velocity_between
from tauten.model.contact.shapes import BoxShape

HALF_TURN = {"axis": [0.0, 0.0, 1.0], "angle_deg": 90.0}
SPEED = 0.02  # m/s


def floor(**table: Any) -> list[dict[str, Any]]:
    """A floor at z = 0 in its own frame."""
    plane = {"point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]}
    return [{"name": "floor", "shape": "plane", "parameters": plane, **table}]


def waypoints(*places: tuple[float, list[float]], **path: Any) -> dict[str, Any]:
    """A path through points at times."""
    return {"path": {"waypoints": [{"time": t, "position": p} for t, p in places], **path}}


def turning(*angles: float, **path: Any) -> dict[str, Any]:
    """A path that turns about z to angles, one a second [deg]."""
    turns = [{"axis": [0.0, 0.0, 1.0], "angle_deg": angle} for angle in angles]
    points = [{"time": float(t), "rotation": turn} for t, turn in enumerate(turns)]
    return {"path": {"waypoints": points, **path}}


def test_a_turned_box_has_the_distances_of_a_box() -> None:
    """Of a box that a file places and turns: those of the same box in the frame that is turned back."""
    lower, upper = [-0.01, -0.02, -0.005], [0.01, 0.02, 0.005]
    turn, place = Rotation.from_rotvec([0.3, -0.5, 0.8]), np.array([0.01, 0.01, -0.03])
    quaternion = np.roll(turn.as_quat(), 1)
    box = {"name": "floor", "shape": "box", "parameters": {"lower": lower, "upper": upper},
           "position": place.tolist(), "rotation": {"quaternion": quaternion.tolist()}}  # fmt: skip
    robot = block(obstacles=[box], contact={"alarm_distance": 0.1})
    rows = robot.rows(robot.rest()).contacts
    points = robot.candidates(robot.rest())
    gap, normal = BoxShape(np.array(lower), np.array(upper)).closest(
        turn.inv().apply(points - place)
    )
    np.testing.assert_allclose(rows.rows.delta, gap, atol=1e-12)
    np.testing.assert_allclose(rows.found.normal, turn.apply(normal), atol=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("how", ["step", "converged", "move", "placed"])
def test_a_floor_that_rises_lifts_a_block_at_its_speed(how: str) -> None:
    """Once it rests on the floor, the block has the speed of the floor, and the force is its weight."""
    end = 10.0
    table = {} if how == "placed" else waypoints((0.0, [0.0] * 3), (end, [0.0, 0.0, end * SPEED]))
    simulator = Simulator(block(obstacles=floor(**table)), "full")
    if how == "placed":
        simulator.place("floor", [0.0, 0.0, 0.0], velocity=[0.0, 0.0, SPEED])
    for _ in range(50):
        if how == "move":
            simulator.move(effort=[0.0], steps=2)
        else:
            simulator.step(effort=[0.0], converged=how == "converged")
    height = simulator.obstacles.poses[0].position[2]
    assert height == pytest.approx(SPEED * 0.5)
    lowest = simulator.robot.candidates(simulator.state)[:, 2].min()
    assert lowest == pytest.approx(height, abs=1e-7)
    weight = 1000.0 * 0.02**3 * 9.81
    np.testing.assert_allclose(force_on(simulator), [0.0, 0.0, weight], rtol=1e-4, atol=1e-9)
    before = simulator.effector[0].copy()
    simulator.step(effort=[0.0])
    np.testing.assert_allclose(
        (simulator.effector[0] - before) * 100.0, [0.0, 0.0, SPEED], atol=1e-6 + 1e-3 * SPEED
    )
    simulator.reset()
    assert simulator.obstacles.poses[0].position[2] == 0.0
    assert simulator.obstacles.time == 0.0


def test_a_pose_in_a_part_that_is_turned_moves_as_in_the_part() -> None:
    """Whether the part is placed first or the time passes first, the obstacle is at the same place."""
    turn = np.roll(Rotation.from_rotvec([0.4, -0.9, 0.3]).as_quat(), 1)
    place = pose_at([0.3, -0.1, 0.2], turn)
    moving = pose_at([0.05, 0.02, 0.0], [0.9, 0.1, -0.2, 0.3], [0.1, -0.2, 0.05], [1.0, 2.0, -0.5])
    first, second = moving.within(place).after(0.2), moving.after(0.2).within(place)
    np.testing.assert_allclose(first.position, second.position, atol=1e-12)
    np.testing.assert_allclose(first.Q, second.Q, atol=1e-12)
    expected = Rotation.from_rotvec([0.4, -0.9, 0.3]).as_matrix() @ moving.after(0.2).Q
    np.testing.assert_allclose(second.Q, expected, atol=1e-12)


def test_the_surface_moves_as_its_nearest_point_does() -> None:
    """Of a turning floor below a block: v + ω x r of the point straight below each candidate."""
    robot = block(obstacles=floor(), contact={"alarm_distance": 0.05, "distance": 0.003})
    place, velocity, spin = (
        [0.01, 0.02, -0.008],
        np.array([0.1, 0.2, 0.3]),
        np.array([1.0, 2.0, 0.5]),
    )
    poses = replace(robot.obstacles, poses=(pose_at(place, velocity=velocity, spin=spin),))
    x = robot.body.mesh.nodes
    found = robot.contacts.placed(poses).detect(x)
    np.testing.assert_allclose(found.gap, found.point[:, 2] + 0.008 - 0.003, atol=1e-12)
    assert found.surface is not None
    below = found.point * [1.0, 1.0, 0.0] + [0.0, 0.0, -0.008]
    np.testing.assert_allclose(found.surface, velocity + np.cross(spin, below - place), atol=1e-12)


@pytest.mark.long
def test_the_force_of_a_floor_is_the_weight_at_an_equilibrium() -> None:
    """A floor that is turned and placed carries the block as one that is not; to 1e-6."""
    turned = floor(position=[0.3, -0.2, 0.0], rotation=HALF_TURN)
    simulator = Simulator(block(obstacles=turned), "full")
    for _ in range(600):
        simulator.step(effort=[0.0])
    np.testing.assert_allclose(force_on(simulator)[2], 1000.0 * 0.02**3 * 9.81, rtol=1e-6)
    np.testing.assert_allclose(force_on(simulator)[:2], 0.0, atol=1e-9)
    (wrench,) = contact_wrenches(simulator.robot, simulator.contacts)
    np.testing.assert_allclose(wrench[2], -1000.0 * 0.02**3 * 9.81, rtol=1e-6)
    x, y = simulator.effector[0][:2]  # the weight acts below the middle of the block
    np.testing.assert_allclose(wrench[3:], [y * wrench[2], -x * wrench[2], 0.0], atol=1e-6)


def test_a_path_is_even_between_waypoints_and_ends_or_starts_again() -> None:
    poses = (pose_at(), pose_at([0.0, 0.0, 2.0], [0.5**0.5, 0.0, 0.0, 0.5**0.5]), pose_at())
    once = ObstaclePath(np.array([0.0, 1.0, 3.0]), poses, loop=False)
    again = ObstaclePath(np.array([0.0, 1.0, 3.0]), poses, loop=True)
    middle = once.at(0.5)
    np.testing.assert_allclose(middle.position, [0.0, 0.0, 1.0])
    np.testing.assert_allclose(middle.velocity, [0.0, 0.0, 2.0])
    np.testing.assert_allclose(middle.spin, [0.0, 0.0, 0.5 * np.pi])
    np.testing.assert_allclose(middle.Q @ [1.0, 0.0, 0.0], [0.5**0.5, 0.5**0.5, 0.0])
    back = once.at(2.0)
    np.testing.assert_allclose(back.position, [0.0, 0.0, 1.0])
    np.testing.assert_allclose(back.velocity, [0.0, 0.0, -1.0])
    assert not once.at(3.0).moves
    assert not once.at(100.0).moves
    for time in (0.2, 1.0, 2.7):
        np.testing.assert_allclose(
            again.at(time + 6.0).position, again.at(time).position, atol=1e-12
        )
    np.testing.assert_allclose(once.at(1.0).position, [0.0, 0.0, 2.0])
    for path, speed in ((once, 2.0), (again, -1.0)):  # before its start by rounding
        start = path.at(-1e-18)
        np.testing.assert_allclose(start.position, 0.0, atol=1e-15)
        np.testing.assert_allclose(start.velocity, [0.0, 0.0, speed])


def test_a_belt_in_a_loop_moves_from_its_start_in_steps_of_any_number() -> None:
    """A box below a block goes to and fro; where a step begins is its start but for rounding."""
    belt = waypoints((0.0, [0.0] * 3), (1.0, [0.0, 0.0, 0.01]), (2.0, [0.0] * 3), loop=True)
    box = {"lower": [-1.0, -1.0, -0.01], "upper": [1.0, 1.0, 0.0]}
    for steps in (2, 3, 5):
        simulator = Simulator(block(obstacles=floor(**belt, shape="box", parameters=box)), "full")
        for _ in range(4):
            simulator.move(effort=[0.0], steps=steps)
        np.testing.assert_allclose(
            simulator.robot.candidates(simulator.state)[:, 2].min(), 4e-4, rtol=1e-6
        )


def test_an_obstacle_turns_all_round_in_a_loop_as_its_waypoints_say() -> None:
    """360° is where it started."""
    robot = block(obstacles=floor(**turning(0.0, 120.0, 240.0, 360.0, loop=True)))
    poses = Simulator(robot, "full").obstacles
    for time in (0.5, 1.5, 2.5, 4.5):
        (pose,) = poses.after(time).poses
        np.testing.assert_allclose(pose.spin, [0.0, 0.0, 2.0 * np.pi / 3.0])


def test_velocities_lead_from_one_pose_to_the_next() -> None:
    rng = np.random.default_rng(2)
    before, after = (pose_at(rng.normal(size=3), rng.normal(size=4)) for _ in range(2))
    moving = velocity_between(before, after, 0.3)
    there = pose_at(before.position, before.quaternion, moving.velocity, moving.spin).after(0.3)
    np.testing.assert_allclose(there.position, after.position)
    np.testing.assert_allclose(there.Q, after.Q, atol=1e-12)
    points = rng.normal(size=(4, 3))
    own = (points - there.position) @ there.Q  # fixed in the frame
    moved = [(own @ one.Q.T + one.position) for one in (there.after(-1e-6), there.after(1e-6))]
    np.testing.assert_allclose((moved[1] - moved[0]) / 2e-6, there.velocity_at(points), rtol=1e-6)


def walled(**table: Any) -> Robot:
    """A beam along x with a cable, its tip 1 mm above a floor that touches nothing else of it."""
    return small_body(
        "linear",
        obstacles=[{"name": "floor", "shape": "plane", "position": [0.0, 0.0, -1e-3],
                    "parameters": {"point": [0.0] * 3, "normal": [0.0, 0.0, 1.0]}, **table}],
        surfaces=[{"name": "below", "box": {"lower": [0.08, -1.0, -1.0], "upper": [1.0] * 3},
                   "normal": [0.0, 0.0, -1.0]}],
        contacts=[{"candidates": "below", "against": "floor", "points": "vertices"}],
        gravity=[0.0, 0.0, 0.0],
    )  # fmt: skip


def test_decisions_know_the_motion_of_an_obstacle() -> None:
    """A wall that moves pushes the model; over the horizon it is where its velocity leads."""
    still, moving = Controller(walled(), "full"), Controller(walled(), "full")
    horizon = moving.horizon.integration.h
    moving.place("floor", [0.0, 0.0, -1e-3], velocity=[0.0, 0.0, SPEED])
    plans = []
    for controller in (still, moving):
        goal = controller.effector_values
        assert controller.decide(goal).status.usable
        decision = controller.last_decision
        assert decision is not None
        assert decision.plan is not None
        plans.append(decision.plan.predicted)
        controller.advance()
    gaps = [plan.step.rows.contacts.rows.delta.min() for plan in plans]
    assert gaps[0] == pytest.approx(1e-3, abs=1e-9)
    assert gaps[1] == pytest.approx(1e-3 - SPEED * horizon, abs=1e-9)
    assert plans[1].contacts_push
    assert not plans[0].contacts_push
    assert moving.obstacles.poses[0].position[2] == pytest.approx(-1e-3 + SPEED * moving.period)
    for _ in range(30):
        moving.step(moving.effector_values)
    height = moving.obstacles.poses[0].position[2]
    assert height > 4e-3
    lowest = moving.robot.candidates(moving.state)[:, 2]
    assert lowest.max() > 0.8 * height, "the tip is on the floor, which has lifted it"
    assert moving.contact_forces[:, 2].sum() > 0.0
    moving.reset()
    assert moving.obstacles.poses[0].position[2] == -1e-3


def test_what_no_obstacle_is_called_cannot_be_placed() -> None:
    simulator = Simulator(block(), "full")
    with pytest.raises(ValueError, match="there is no obstacle 'wall', known are floor"):
        simulator.place("wall", [0.0, 0.0, 0.0])
    for no_number in ({}, "here", [1j, 0.0, 0.0], [10**400, 0.0, 0.0], object()):
        with pytest.raises(ValueError, match="a pose has numbers only"):
            simulator.place("floor", no_number)  # type: ignore[arg-type]
    for wrong in ({"position": [np.nan, 0.0, 0.0]}, {"quaternion": [0.0] * 4}, {"spin": [1.0]}):
        with pytest.raises(ValueError, match="a pose"):
            simulator.place("floor", **{"position": [0.0] * 3, **wrong})  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", [Simulator, Controller])
def test_poses_of_another_kind_or_of_other_obstacles_are_refused(
    kind: type[Simulator] | type[Controller],
) -> None:
    model = kind(block(), "full")
    for none in (None, "floor", [pose_at()], pose_at()):
        sentence = f"^poses: expected ObstaclePoses, found {type(none).__name__}$"
        with pytest.raises(TypeError, match=sentence):
            model.set_obstacles(none)  # type: ignore[arg-type]
    wall = [{**floor()[0], "name": "wall"}]
    contacts = [{"candidates": "below", "against": "wall", "points": "vertices"}]
    other = block(obstacles=wall, contacts=contacts)
    with pytest.raises(ValueError, match=r"^poses: found those of wall, expected those of floor$"):
        model.set_obstacles(other.obstacles)
    with pytest.raises(ValueError, match=r"^poses: found those of none, expected those of floor$"):
        model.set_obstacles(ObstaclePoses((), ()))
    model.set_obstacles(block().obstacles)  # of the same file, loaded again


REFUSED: dict[str, dict[str, Any]] = {
    "contacts.0.against: the obstacle 'floor' is in the robot at rest: the surface is 1 mm deep in it at": {
        "position": [0.0, 0.0, 1e-3]
    },
    "obstacles.floor: the obstacle is in the robot at rest: [0.007, 0.004, 0.004] m of its surface": {
        "shape": "box", "parameters": {"lower": [-0.003] * 3, "upper": [0.003] * 3},
        "position": [0.01, 0.007, 0.007],
    },
    "obstacles.0.parameters.heights.0.1: Input should be a finite number, found nan": {
        "shape": "height-field", "parameters": {"heights": [[0.0, np.nan], [0.0, 0.0]]},
    },
    "obstacles.0.path: the times of waypoints start with 0 and ascend": waypoints(
        (0.0, [0.0] * 3), (0.0, [0.0] * 3)
    ),
    "obstacles.0.path: a path with loop ends where it starts": waypoints(
        (0.0, [0.0] * 3), (1.0, [0.0, 0.0, 1.0]), loop=True
    ),
    "between waypoints 1 and 2 the obstacle turns by 180 degrees or more": turning(0.0, 90.0, 300.0),
    "an obstacle has a path or a stream, not both": {
        **waypoints((0.0, [0.0] * 3), (1.0, [0.0] * 3)), "stream": {"largest_speed": 1.0}
    },
    "path: where it starts is its first waypoint": {
        **waypoints((0.0, [0.0] * 3), (1.0, [0.0] * 3)), "position": [0.0, 0.0, 0.0]
    },
    "stream.largest_speed: allowed is more than 0": {"stream": {"largest_speed": 0.0}},
}  # fmt: skip


@pytest.mark.parametrize("sentence", REFUSED)
def test_what_is_no_motion_is_refused(sentence: str) -> None:
    with pytest.raises(RobotFileError, match=re.escape(sentence)):
        block(obstacles=floor(**REFUSED[sentence]))


@pytest.mark.long
@pytest.mark.parametrize("how", ["step", "move"])
def test_a_belt_takes_a_block_along_by_friction(how: str) -> None:
    """At mu g until the block has the speed of the belt."""
    mu, speed, h = 0.3, 0.2, 0.01
    rubbing = [{"candidates": "below", "against": "floor", "points": "vertices", "friction": mu}]
    simulator = Simulator(block(obstacles=floor(), contacts=rubbing), "full")
    for _ in range(60):
        simulator.step(effort=[0.0])
    simulator.place("floor", [0.0, 0.0, 0.0], velocity=[speed, 0.0, 0.0])
    places = [simulator.effector[0][0]]
    for _ in range(30):
        simulator.step(effort=[0.0]) if how == "step" else simulator.move(effort=[0.0])
        places.append(simulator.effector[0][0])
    speeds = np.diff(places) / h
    np.testing.assert_allclose(speeds[4], mu * 9.81 * 5.0 * h, rtol=0.1)
    np.testing.assert_allclose(speeds[-3:], speed, rtol=0.02)
