"""A pad rolls a ball to its target through contact alone: without contact the ball stays in place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.examples import changed, example

from tauten.model import Robot, Simulator, load_robot
from tauten.model.numerics import Array

ROLL = example("14_roll")
PAD = """[[contacts]]
candidates = { part = "ball" }
against = { part = "pad", surface = "below" }
points = "vertices"
friction = 0.5
min_force = 0.5              # N: the pad stays on the ball
"""
WAY = (-0.0009, 0.0012)


def rolled(
    robot: Robot, seconds: float = 0.4, rest: float = 0.3, way: tuple[float, float] = WAY
) -> tuple[Simulator, Array]:
    """The simulator at the end of a target's way and a rest, and how far the ball has gone."""
    *_, simulator = ROLL["roll"](robot, way, seconds, rest)
    return simulator, ROLL["moved"](simulator)


@pytest.mark.long
@pytest.mark.parametrize(
    "way",
    [WAY, pytest.param((-0.0009, 0.00121), marks=pytest.mark.slow)],  # nearly the same
)
def test_a_pad_rolls_a_ball_to_its_target(way: tuple[float, float]) -> None:
    """And keeps the force on it that its file asks for; rounding decides how much more (docs/grasping.md)."""
    simulator, moved = rolled(load_robot(ROLL["FILE"]), rest=0.8, way=way)
    assert np.linalg.norm(moved - way) < 2e-4
    x, y = ROLL["turned"](simulator)  # rolls without sliding
    np.testing.assert_allclose(ROLL["RADIUS"] * np.array([y, -x]), moved, atol=2e-4)
    found, weight = simulator.contacts, 9.81 * simulator.robot.body.part_robots[1].body.moving_mass
    floor = found.force[found.contacts.pair == 1].sum(axis=0)
    pressed = ROLL["pressed"](simulator)
    assert 0.45 < pressed < 1.0
    assert floor[2] == pytest.approx(weight + pressed, rel=0.01)


@pytest.mark.long
def test_without_contact_the_ball_stays(tmp_path: Path) -> None:
    _, moved = rolled(load_robot(changed(tmp_path, "roll.toml", (PAD, ""))), 0.2, 0.0)
    assert np.linalg.norm(moved) < 1e-6
