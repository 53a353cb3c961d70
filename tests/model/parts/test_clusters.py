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
from tauten.model import Robot, clusters_of
from tauten.model.load import build_robot, shipped_folder
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig, validated
from tauten.model.tetra import NodalBody

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


def pair(mesh: TetMesh, **changes: object) -> Robot[NodalBody]:
    """Two bodies side by side without parts, each with a cable and an effector."""
    root = {"lower": [0.0, -1.0, -1.0], "upper": [0.0, 1.0, 1.0]}
    rows = {"one": 0.0, "other": 0.1}
    settings = {
        "name": "pair", "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0},
        "bodies": [{"name": name, "mesh": {"file": "box.vtu"}, "position": [0.0, y, 0.0], "fixed": [root]}
                   for name, y in rows.items()],
        "cables": [{**CABLE, "name": name, "pull_point": [-0.01, y + 0.01, 0.002],
                    "points": [[0.01, y + 0.01, 0.002], [0.1, y + 0.01, 0.002]]} for name, y in rows.items()],
        "effectors": [{"name": name, "point": [0.1, y + 0.01, 0.01]} for name, y in rows.items()],
        "surfaces": [{"name": name, "box": {"lower": [-1.0, y, -1.0], "upper": [1.0, y + 0.02, 1.0]}}
                     for name, y in rows.items()],
        "obstacles": [{"name": "table", "shape": "plane",
                       "parameters": {"point": [0.0, 0.0, -4e-3], "normal": [0.0, 0.0, 1.0]}}],
        **changes,
    }  # fmt: skip
    config = validated(RobotConfig, settings, "pair.toml")
    return build_robot(config, [mesh, mesh], "pair.toml")


BOX = box_mesh((0.1, 0.02, 0.02), (4, 1, 1))


@pytest.mark.parametrize("first", ["fixed", "free"])
def test_cables_that_start_in_space_join_no_bodies(first: str) -> None:
    """Whatever node the mesh begins with: a point in space was held by that of the first body."""
    last = len(BOX.nodes) - 1
    mesh = BOX if first == "fixed" else TetMesh(BOX.nodes[::-1].copy(), last - BOX.tets)
    assert [one.actuators.tolist() for one in clusters_of(pair(mesh)).each] == [[0], [1]]


ON_TABLE = [{"candidates": name, "against": "table", "points": 8} for name in ("one", "other")]


@pytest.mark.parametrize(
    ("contacts", "actuators", "of_pairs"),
    [
        (ON_TABLE, [[0], [1]], [0, 1]),
        (ON_TABLE[1:], [[0], [1]], [1]),
        ([*ON_TABLE, {"candidates": "one", "against": "other", "points": 8}], [[0, 1]], [0, 0, 0]),
        ([{"against": "table", "points": 8}], [[0, 1]], [0]),  # of the whole surface
    ],
)
def test_a_contact_joins_the_bodies_that_it_is_on_alone(
    contacts: list[dict[str, object]], actuators: list[list[int]], of_pairs: list[int]
) -> None:
    """Without parts any contact joined all bodies."""
    found = clusters_of(pair(BOX, contacts=contacts))
    assert [one.actuators.tolist() for one in found.each] == actuators
    assert found.of_pairs.tolist() == of_pairs


def test_a_body_on_the_table_does_not_move_another_one() -> None:
    """A target that one of two cannot reach moved the other, which has a contact of its own, by 0.03 mm."""
    robot, tips = pair(BOX, contacts=ON_TABLE), list[Array]()
    for away in (0.0, -0.3):
        controller = Controller(robot)
        start, found = controller.effector_values, []
        for tick in range(40):
            change = np.array([0.0, 0.0, away, 0.0, 0.0, 0.004 * (np.cos(0.12 * tick) - 1.0)])
            controller.step(start + change)
            found.append(controller.effector_values)
        tips.append(np.array(found))
    apart = np.abs(tips[1] - tips[0]).max(axis=0)  # (6,) m
    assert apart[2] > 1e-3
    assert apart[3:].max() < 1e-7


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
