"""An obstacle or an object that is too far away to be touched changes nothing."""

from __future__ import annotations

import tomllib
from functools import cache
from typing import Any

import numpy as np
import pytest
from support.robots.examples import EXAMPLES

from tauten.controller import Controller, ControllerSetup, controller_setup
from tauten.model import Simulator
from tauten.model.load import shipped_folder
from tauten.model.numerics import Array

BALL = {
    "name": "ball",
    "shape": "sphere",
    "parameters": {"centre": [5.0, 5.0, 5.0], "radius": 0.1},
}


def started(setup: ControllerSetup) -> Controller:
    """A controller at the equilibrium under the robot's loads."""
    one = Controller(setup.robot, setup.contact, settings=setup.controller)
    assert one.settle_start().converged
    return one


def decided(contents: dict[str, Any]) -> tuple[Array, Array]:
    """Positions and efforts (steps, n_a) for random targets; the file would lie beside the shipped ones."""
    setup = controller_setup(contents, shipped_folder() / "robot.toml")
    one = started(setup)
    layout, start = one.robot.effector_layout, one.effector_values
    rng, found = np.random.default_rng(1), []
    for _ in range(6):
        way = 0.002 * rng.standard_normal(len(layout.units)) / layout.units
        found.append(one.step(layout.moved(start, way)))
    return np.array([one.position for one in found]), np.array([one.effort for one in found])


def shipped(name: str) -> dict[str, Any]:
    """The file of a shipped robot, to be decided for all of its contacts."""
    contents = tomllib.loads((shipped_folder() / f"{name}.toml").read_text(encoding="utf-8"))
    contents["controller"]["basis"] = "full"
    return contents


@cache
def decided_alone(name: str) -> tuple[Array, Array]:
    """What is decided for a shipped robot with nothing around it."""
    return decided(shipped(name))


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("name", ["trunk", "finger"])
def test_an_obstacle_far_away_changes_no_bit(name: str, friction: float) -> None:
    """The trunk's cables become slack and taut in the steps, and the finger's notches close."""
    contents = shipped(name)
    far = {"against": "ball", "points": 20, **({"friction": friction} if friction else {})}
    among = {**contents, "obstacles": [BALL], "contacts": [*contents.get("contacts", []), far]}
    position, effort = decided_alone(name)
    assert (effort == 0.0).any() or name == "finger"
    again, efforts = decided(among)
    np.testing.assert_array_equal(again, position)
    np.testing.assert_array_equal(efforts, effort)


def beside_a_cube(name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Files of a shipped robot alone, and beside a cube that rests on a floor 10 m away."""
    arm = {"name": "arm", "robot": name}
    cube = {"name": "cube", "robot": str(EXAMPLES / "cube.toml"), "position": [10.0, 0.0, 0.012]}
    floor = {
        "name": "floor",
        "shape": "box",
        "parameters": {"lower": [9.0, -1.0, -1.0], "upper": [11.0, 1.0, 0.0]},
    }
    rests = {
        "candidates": {"part": "cube"},
        "against": "floor",
        "points": "vertices",
        "friction": 0.5,
    }
    touches = {**rests, "against": {"part": "arm"}}
    alone = {"name": "world", "parts": [arm]}
    beside = {**alone, "parts": [arm, cube], "obstacles": [floor], "contacts": [rests, touches]}
    return alone, beside


@pytest.mark.long
def test_an_object_far_away_changes_no_motion() -> None:
    """The trunk's cables become slack and taut in the steps."""
    ends = []
    for contents in beside_a_cube("trunk"):
        setup = controller_setup(contents, EXAMPLES / "world.toml", model="reduced", basis="full")
        simulator, rng = Simulator(setup.robot, "full"), np.random.default_rng(1)
        assert simulator.settle_start().converged
        slack = 0
        for _ in range(8):
            simulator.move(position=rng.uniform(-0.004, 0.004, setup.robot.n_a))
            slack += int((simulator.effort == 0.0).sum())
            ends.append(simulator.effector_values)
        assert 0 < slack < 8 * setup.robot.n_a
    np.testing.assert_allclose(ends[8:], ends[:8], rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("name", ["trunk", "tripod"])
def test_an_object_far_away_changes_no_decision(name: str) -> None:
    """While the goal jumps or stays far: where plans fade depends on the size of all parts together."""
    found = []
    for contents in beside_a_cube(name):
        setup = controller_setup(contents, EXAMPLES / "world.toml", model="reduced", basis="full")
        one, rng = started(setup), np.random.default_rng(1)
        layout, start = one.robot.effector_layout, one.effector_values
        goal = layout.moved(start, 0.004 * rng.standard_normal(len(layout.units)) / layout.units)
        found.append([one.step(goal).position for _ in range(4)])
    np.testing.assert_allclose(found[1], found[0], rtol=0.0, atol=1e-6 * np.abs(found[0]).max())
