"""Large time steps of beams: nodes move along arcs, so that what turns keeps its length."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.beam_robots import build, path_of_beams, rectangle

from tauten.model import Robot, Simulator
from tauten.model.beams import BeamBody
from tauten.model.numerics import Array
from tauten.model.state import State

LENGTH, RATE = 0.5, 50.0


def cantilever(
    folder: Path, rate: float = RATE, count: int = 8, held: bool = True
) -> Robot[BeamBody]:
    """A strip along x, held at its first node, or at both ends, damped as the manipulator is."""
    nodes = np.zeros((count + 1, 3))
    nodes[:, 0] = np.linspace(0.0, LENGTH, count + 1)
    beams = path_of_beams(nodes, (0.0, 0.0, 1.0), "strip")
    profile = rectangle("strip", 0.02, 0.004)
    return build(
        folder, nodes, beams, [profile], (2e8, 0.3, 1100.0), [0] if held else [0, count], 1,
        controller={"rate": rate},
        integration={"rayleigh_mass": 1.0, "rayleigh_stiffness": 0.02},
    )  # fmt: skip


def moved(robot: Robot[BeamBody], start: State, step: Array) -> State:
    """The state after displacements and turns (n,) of the nodes."""
    return robot.advance(start, step / robot.h, robot.h)


def test_a_beam_that_turns_at_its_clamp_keeps_its_length(tmp_path: Path) -> None:
    """Straight lines would stretch it by half the square of the angle, here 18 %."""
    robot, angle = cantilever(tmp_path), 0.6
    rest = robot.rest()
    x = robot.body.pose(rest)[0]
    turn = np.array([0.0, angle, 0.0])
    # the first element bends, the others turn with its end
    bent = x[1] + np.array([0.0, 0.0, -0.5 * angle * x[1, 0]])
    step = np.zeros((len(x), 6))
    step[1:, :3] = bent - x[1] + np.cross(turn, x[1:] - x[1])
    step[1:, 3:] = turn
    end = moved(robot, rest, step[1:].ravel())
    after = robot.body.pose(end)[0]
    lengths = np.linalg.norm(np.diff(after, axis=0), axis=1)
    arc = (LENGTH / 8) * np.sin(angle / 2) / (angle / 2)  # the chord of the first one
    np.testing.assert_allclose(lengths, [arc, *[LENGTH / 8] * 7], rtol=1e-12)
    np.testing.assert_allclose(
        robot.body.velocity(rest, end) * robot.h, step[1:].ravel(), atol=1e-12
    )


def test_small_steps_are_straight_to_first_order(tmp_path: Path) -> None:
    """Their difference from straight ones falls with the square of the step."""
    robot = cantilever(tmp_path)
    rng = np.random.default_rng(0)
    start = moved(robot, robot.rest(), 0.05 * rng.normal(size=robot.n))
    step = rng.normal(size=(robot.n // 6, 6)) * [0.01, 0.01, 0.01, 0.1, 0.1, 0.1]
    errors = []
    for share in (0.1, 0.05):
        after = robot.body.pose(moved(robot, start, share * step.ravel()))[0][1:]
        errors.append(np.abs(after - robot.body.pose(start)[0][1:] - share * step[:, :3]).max())
    assert errors[0] == pytest.approx(4.0 * errors[1], rel=0.1)


def test_beams_in_a_loop_move_along_straight_lines(tmp_path: Path) -> None:
    robot = cantilever(tmp_path, held=False)
    assert robot.body.tree is None
    step = 0.01 * np.random.default_rng(1).normal(size=(robot.n // 6, 6))
    end = moved(robot, robot.rest(), step.ravel())
    np.testing.assert_allclose(
        robot.body.pose(end)[0][1:-1] - robot.body.pose(robot.rest())[0][1:-1],
        step[:, :3],
        atol=1e-15,
    )
    np.testing.assert_allclose(
        robot.body.velocity(robot.rest(), end) * robot.h, step.ravel(), atol=1e-12
    )


def fallen(robot: Robot[BeamBody], steps: int, converged: bool) -> Array:
    """The tip (3,) after some steps of a fall from rest."""
    simulator = Simulator(robot, contact="none")
    for _ in range(steps):
        simulator.step(effort=[0.0], converged=converged)
    return robot.body.pose(simulator.state)[0][-1]


@pytest.mark.long
@pytest.mark.parametrize("converged", [False, True])
def test_a_strip_that_falls_meets_shorter_steps(tmp_path: Path, converged: bool) -> None:
    """Under its weight, by 40 degrees in 15 steps; straight lines hold it back."""
    tips = {}
    for part, flat in ((1, False), (1, True), (16, False)):
        robot = cantilever(tmp_path, part * RATE).loaded(np.array([0.0, 0.0, -9.81]), np.zeros(3))
        if flat:
            robot = replace(robot, body=replace(robot.body, tree=None))
        tips[part, flat] = fallen(robot, 15 * part, converged)
    along, straight = (np.linalg.norm(tips[1, flat] - tips[16, False]) for flat in (False, True))
    assert along < 0.06 * LENGTH
    assert straight > 3.0 * along
