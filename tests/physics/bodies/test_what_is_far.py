"""An obstacle that is too far away to be touched changes nothing."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np
import pytest

from tauten.controller import controller_setup, warm_controller
from tauten.model.load import shipped_folder
from tauten.model.numerics import Array

BALL = {
    "name": "ball",
    "shape": "sphere",
    "parameters": {"centre": [5.0, 5.0, 5.0], "radius": 0.1},
}


def decided(contents: dict[str, Any]) -> tuple[Array, Array]:
    """Positions and efforts (steps, n_a) for random targets; the file would lie beside the shipped ones."""
    one = warm_controller(controller_setup(contents, shipped_folder() / "robot.toml"))
    layout, start = one.robot.effector_layout, one.effector_values
    rng, found = np.random.default_rng(1), []
    for _ in range(6):
        way = 0.002 * rng.standard_normal(len(layout.units)) / layout.units
        found.append(one.step(layout.moved(start, way)))
    return np.array([one.position for one in found]), np.array([one.effort for one in found])


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("name", ["trunk", "finger"])
def test_an_obstacle_far_away_changes_no_bit(name: str, friction: float) -> None:
    """The trunk's cables become slack and taut in the steps, and the finger's notches close."""
    contents = tomllib.loads((shipped_folder() / f"{name}.toml").read_text(encoding="utf-8"))
    contents["controller"]["basis"] = "full"
    far = {"against": "ball", "points": 20, **({"friction": friction} if friction else {})}
    among = {**contents, "obstacles": [BALL], "contacts": [*contents.get("contacts", []), far]}
    position, effort = decided(contents)
    assert (effort == 0.0).any() or name == "finger"
    again, efforts = decided(among)
    np.testing.assert_array_equal(again, position)
    np.testing.assert_array_equal(efforts, effort)
