"""Parts that nothing joins are decided as each is alone."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.robots.bodies import CABLE, box_mesh
from support.robots.examples import EXAMPLES

from tauten.controller import Controller, ControllerSetup, controller_setup
from tauten.model import clusters_of
from tauten.model.load import build_robot, shipped_folder
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig, validated

HAND, GRIPPER = EXAMPLES / "hand.toml", shipped_folder() / "gripper.toml"


@pytest.mark.long
@pytest.mark.parametrize(
    ("file", "model", "actuators"),
    [
        (HAND, "reduced", [[0], [1], [2]]),
        (GRIPPER, "full", [[0], [1], [2]]),
        (GRIPPER, "reduced", [[0, 1, 2]]),  # modes of all fingers
        (EXAMPLES / "lift.toml", "full", [[0, 1]]),  # what the claw may lift
        (shipped_folder() / "trunk.toml", "full", [[*range(8)]]),
    ],
)
def test_clusters_are_what_neither_bodies_nor_contact_join(
    file: Path, model: str, actuators: list[list[int]]
) -> None:
    contents = tomllib.loads(file.read_text(encoding="utf-8"))
    robot = controller_setup(contents, file, model=model).robot
    found = clusters_of(robot)
    assert [one.actuators.tolist() for one in found.each] == actuators
    rows = np.concatenate([one.rows for one in found.each])
    assert sorted(rows.tolist()) == list(range(robot.layout.contacts.start))
    values = np.concatenate([one.values for one in found.each])
    assert sorted(values.tolist()) == list(range(robot.effector_layout.n_values))


@pytest.mark.parametrize("first", ["fixed", "free"])
def test_cables_that_start_in_space_join_no_bodies(first: str) -> None:
    """Whatever node the mesh begins with: a point in space was held by that of the first body."""
    box = box_mesh((0.1, 0.02, 0.02), (4, 1, 1))
    last = len(box.nodes) - 1
    mesh = box if first == "fixed" else TetMesh(box.nodes[::-1].copy(), last - box.tets)
    root = {"lower": [0.0, -1.0, -1.0], "upper": [0.0, 1.0, 1.0]}
    rows = {"one": 0.0, "other": 0.1}
    settings = {
        "name": "pair", "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0},
        "bodies": [{"name": name, "mesh": {"file": "box.vtu"}, "position": [0.0, y, 0.0], "fixed": [root]}
                   for name, y in rows.items()],
        "cables": [{**CABLE, "name": name, "pull_point": [-0.01, y + 0.01, 0.002],
                    "points": [[0.01, y + 0.01, 0.002], [0.1, y + 0.01, 0.002]]} for name, y in rows.items()],
        "effectors": [{"name": name, "point": [0.1, y + 0.01, 0.01]} for name, y in rows.items()],
    }  # fmt: skip
    robot = build_robot(validated(RobotConfig, settings, "pair.toml"), [mesh, mesh], "pair.toml")
    assert [one.actuators.tolist() for one in clusters_of(robot).each] == [[0], [1]]


@cache
def hand() -> ControllerSetup:
    """The reduced hand."""
    contents = tomllib.loads(HAND.read_text(encoding="utf-8"))
    return controller_setup(contents, HAND, model="reduced")


def fingers(away: Array) -> tuple[Array, Array]:
    """Positions (s, 3) and tips (s, 9) of the hand: one finger's target is elsewhere, another's moves."""
    one = Controller(hand().robot, hand().contact, settings=hand().controller)
    assert one.settle_start().converged
    start, found = one.effector_values, []
    for tick in range(80):
        goal, angle = start.copy(), 0.06 * tick
        goal[:3] += away
        goal[3:5] += 0.004 * np.array([np.cos(angle) - 1.0, 0.3 * np.sin(angle)])
        one.step(goal)
        assert one.status.ok
        found.append((one.position, one.effector_values))
    positions, tips = zip(*found, strict=True)
    return np.array(positions), np.array(tips)


@pytest.mark.long
def test_a_target_that_one_finger_cannot_reach_changes_nothing_for_another() -> None:
    """It trembled by 0.2 mm of cable in every tick, and the others moved by up to 0.5 mm otherwise."""
    positions, tips = fingers(np.array([0.1, 0.0, 0.0]))
    _, alone = fingers(np.zeros(3))
    assert np.abs(np.diff(positions[-20:, 0])).max() < 1e-6
    assert np.abs(tips[-1, :3] - alone[-1, :3]).max() > 1e-3  # it goes where it can
    assert np.abs(tips[:, 3:] - alone[:, 3:]).max() < 2e-6
