"""Candidates stay on the side of an obstacle where they were, however far one of them moves in a step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.robots.blocks import block, force_on
from support.robots.bodies import box_mesh, without

from tauten.controller import Controller
from tauten.model import Simulator, State
from tauten.model.contact import Obstacle, ObstaclePose, Shape, pose_at
from tauten.model.contact.shapes import BoxShape, SphereShape
from tauten.model.contact.sides import sides_of
from tauten.model.mesh import boundary_triangles
from tauten.model.numerics import Array

MASS = 1000.0 * 0.02**3  # kg, of the block
H = 0.1  # s


def plate(thickness: float, **table: Any) -> list[dict[str, Any]]:
    """A plate whose top is at z = 0 in its own frame."""
    shape = {"lower": [-0.1, -0.1, -thickness], "upper": [0.1, 0.1, 0.0]}
    return [{"name": "floor", "shape": "box", "parameters": shape, **table}]


def slow(thickness: float = 0.02, **table: Any) -> Simulator:
    """A block on a plate, ten steps a second."""
    robot = block(obstacles=plate(thickness, **table), controller={"rate": 1.0 / H})
    return Simulator(robot, "full")


def stepped(simulator: Simulator, how: str) -> None:
    if how == "move":
        simulator.move(effort=[0.0])
    else:
        simulator.step(effort=[0.0], converged=how == "converged")


def lowest(simulator: Simulator) -> float:
    return float(simulator.robot.candidates(simulator.state)[:, 2].min())


@pytest.mark.parametrize("how", ["step", "converged", "move"])
@pytest.mark.parametrize(
    "rise", [0.01, 0.05]
)  # m in a step: half of the plate, and more than all of it
def test_a_plate_that_rises_by_its_thickness_in_a_step_lifts_a_block(how: str, rise: float) -> None:
    """By hand: the block has the height of the plate, and the plate gives it weight and momentum."""
    simulator = slow()
    for _ in range(5):
        stepped(simulator, how)
    simulator.place("floor", [0.0] * 3, velocity=[0.0, 0.0, rise / H])
    forces = []
    for step in range(1, 4):
        stepped(simulator, how)
        assert lowest(simulator) > step * rise - 2e-6
        assert lowest(simulator) < step * rise + 2e-6
        forces.append(force_on(simulator)[2])
    weight = 9.81 * MASS
    assert forces[2] == pytest.approx(weight, rel=0.02)
    if how != "move":  # whose forces are those of its last stage
        assert forces[0] == pytest.approx(weight + MASS * rise / H**2, rel=0.05)


@pytest.mark.parametrize("how", ["step", "converged", "move"])
def test_a_block_that_falls_fast_does_not_pass_a_plate(how: str) -> None:
    """At 3 m/s it would be 0.3 m lower after a step, far beyond a plate of 5 mm."""
    simulator = slow(0.005, position=[0.0, 0.0, -0.06])
    state = simulator.state
    fall = np.zeros_like(state.v)
    fall[2::3] = -3.0
    simulator.start_from(State(state.q, fall, state.memory))
    for _ in range(3):
        stepped(simulator, how)
        assert lowest(simulator) > -0.06 - 1e-4
    simulator.step(effort=[0.0])
    assert force_on(simulator)[2] == pytest.approx(9.81 * MASS, rel=0.1)


def test_the_model_of_a_controller_stays_above_a_plate_that_rises() -> None:
    robot = block(obstacles=plate(0.02), controller={"rate": 1.0 / H})
    controller = Controller(robot, "full")
    for _ in range(3):
        controller.step(controller.effector_values)
    controller.place("floor", [0.0] * 3, velocity=[0.0, 0.0, 0.15])
    for _ in range(3):
        controller.step(controller.effector_values)
    height = controller.obstacles.poses[0].position[2]
    assert height == pytest.approx(0.045)
    assert controller.robot.candidates(controller.state)[:, 2].min() > height - 1e-4


def gap_after(
    shape: Shape, before: ObstaclePose, after: ObstaclePose, start: Array, end: Array
) -> tuple[float, Array]:
    """Gap and normal of a point at the end of a step."""
    obstacle = Obstacle("one", shape, before)
    sides = sides_of(obstacle, (start[None], before), (end[None], after))
    gap, normal = sides.corrected(
        end[None], after, obstacle.closest(end[None], after, 0.005), 0.005
    )
    return float(gap[0]), normal[0]


def test_a_point_that_a_ball_has_passed_is_before_where_it_met_it() -> None:
    """12 mm above the centre of a ball of 10 mm that rises by 25 mm, and by 50 mm: 23 and 48 mm deep."""
    point = np.array([0.0, 0.0, 0.012])
    for rise in (0.025, 0.05):
        found = gap_after(
            SphereShape(np.zeros(3), 0.01), pose_at(), pose_at([0, 0, rise]), point, point
        )
        assert found[0] == pytest.approx(0.002 - rise, abs=1e-5)
        np.testing.assert_allclose(found[1], [0.0, 0.0, 1.0], atol=1e-12)


def test_a_point_that_a_paddle_has_passed_is_before_its_face() -> None:
    """A paddle of 2 mm turns by 30 degrees; a point 10 degrees before it stays there, 20 degrees deep."""
    paddle, radius = BoxShape(np.array([0.0, -1e-3, -0.1]), np.array([0.1, 1e-3, 0.1])), 0.05
    turn = Rotation.from_rotvec([0.0, 0.0, np.radians(30.0)])
    after = pose_at(quaternion=np.roll(turn.as_quat(), 1))
    point = radius * np.array([np.cos(np.radians(10.0)), np.sin(np.radians(10.0)), 0.0])
    gap, normal = gap_after(paddle, pose_at(), after, point, point)
    assert gap == pytest.approx(-radius * np.sin(np.radians(20.0)) - 1e-3, abs=1e-9)
    np.testing.assert_allclose(normal, turn.apply([0.0, 1.0, 0.0]), atol=1e-12)


def test_a_point_that_goes_round_a_corner_or_past_a_box_is_where_it_is() -> None:
    box = BoxShape(np.array([-0.01] * 3), np.array([0.01] * 3))
    start = np.array([0.0, 0.0, 0.011])
    for end in ([0.03, 0.0, 0.011], [0.004, 0.0, 0.0102]):
        gap, normal = gap_after(box, pose_at(), pose_at(), start, np.array(end))
        away = np.hypot(max(end[0] - 0.01, 0.0), end[2] - 0.01)
        assert gap == (pytest.approx(away) if away < 0.005 else np.inf)
        if np.isfinite(gap):
            np.testing.assert_allclose(normal, [0.0, 0.0, 1.0])


def test_nothing_is_looked_for_beside_a_plane() -> None:
    """It has one side, wherever it moves, and costs a step nothing."""
    over = {"velocity": [0.0, 0.0, 1.0]}
    simulator = Simulator(block(), "full")
    simulator.place("floor", [0.0] * 3, **over)
    assert simulator.robot.stepping(simulator.state) is simulator.robot
    other = slow()
    other.place("floor", [0.0] * 3, **over)
    assert other.robot.stepping(other.state) is not other.robot


@pytest.mark.parametrize("shape", ["plane", "box"])
@pytest.mark.parametrize("speed", [0.25, 3.0])  # m/s; it comes from beyond the alarm distance
def test_a_block_that_falls_fast_does_not_rebound_from_what_was_out_of_range(
    shape: str, speed: float
) -> None:
    """Steps that detect contacts at their start: the floor was found too late and threw the block up."""
    walls = {
        "plane": {"point": [0.0] * 3, "normal": [0.0, 0.0, 1.0]},
        "box": {"lower": [-0.1] * 3, "upper": [0.1, 0.1, 0.0]},
    }
    floor = {"name": "floor", "shape": shape, "parameters": walls[shape]}
    robot = block(
        bodies=[{"name": "cube", "mesh": {"file": "cube.vtu"}, "free": True, "rigid": True}],
        obstacles=[{**floor, "position": [0.0, 0.0, -0.0097]}], gravity=[0.0] * 3,
    )  # fmt: skip
    simulator = Simulator(robot, "full")
    state, fall = simulator.state, np.array([0.0, 0.0, -speed, 0.0, 0.0, 0.0])
    simulator.start_from(State(state.q, fall, state.memory))
    for _ in range(round(0.0097 * 100.0 / speed) + 5):
        simulator.step(effort=[0.0])
        assert lowest(simulator) > -0.0097 - 1e-5
        assert simulator.state.v[2] < 1e-3 * speed
    assert lowest(simulator) < -0.0097 + 1e-5


@pytest.mark.parametrize(("gap", "speed"), [(0.0201, 3.0), (0.031, 0.3)])  # m, m/s
def test_a_block_that_slides_into_a_corner_of_one_obstacle_stops_there(
    gap: float, speed: float, tmp_path: Path
) -> None:
    """By hand: of rigid bodies without elasticity nothing remains; the wall holds what slid on the floor."""
    mesh = box_mesh((0.15, 0.12, 0.15), (3, 1, 3))
    corner = without(mesh, [(np.array([0.05, -1.0, 0.05]), np.ones(3))])
    triangles = [("triangle", boundary_triangles(corner.tets))]
    meshio.write(tmp_path / "corner.stl", meshio.Mesh(corner.nodes - 0.05, triangles))
    shape = {"file": str(tmp_path / "corner.stl"), "length_unit": "m"}
    robot = block(
        cells=1,
        bodies=[{"name": "cube", "mesh": {"file": "cube.vtu"}, "free": True, "rigid": True,
                 "position": [gap, 0.0, 1e-5]}],
        obstacles=[{"name": "corner", "shape": "mesh", "parameters": shape}],
        contacts=[{"against": "corner", "points": "vertices"}],
    )  # fmt: skip
    simulator = Simulator(robot, "full")
    state, way = simulator.state, np.array([-speed, 0.0, 0.0, 0.0, 0.0, 0.0])
    simulator.start_from(State(state.q, way, state.memory))
    for _ in range(round(100.0 * gap / speed) + 10):
        simulator.move(effort=[0.0])
        candidates = robot.candidates(simulator.state)
        assert candidates[:, [0, 2]].min() > -2e-4
    assert np.abs(simulator.state.v[:3]).max() < 0.02 * speed
    np.testing.assert_allclose(simulator.effector[0, [0, 2]], 0.01, atol=1e-3)
