"""Robots of other sizes: nothing but the dimensions of the quantities tells them apart.

Lengths are s times as large, density and times are the same. Then accelerations and gravity grow with s,
stresses and Young's moduli with s², forces with s⁴ and torques with s⁵, and in these units the larger robot
decides and moves as the other one. A constant in metres or newtons anywhere between the robot file and the
actuation would show. With a power of two all numbers but those that add angles to lengths are scaled exactly.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from support.robots.examples import EXAMPLES

from tauten.controller import Controller, controller_setup
from tauten.model import Simulator
from tauten.model.load import make_robot, shipped_folder
from tauten.model.numerics import Array
from tauten.model.schema import Changes

POWERS = {
    "lower": 1, "upper": 1, "point": 1, "points": 1, "pull_point": 1, "through": 1, "start": 1, "end": 1,
    "radius": 1, "position": 1, "inside": 1, "max_pull": 1, "gravity": 1, "alarm_distance": 1, "tolerance": 1,
    "min_pressure": 2, "max_pressure": 2, "max_volume_change": 3, "max_tension": 4, "max_torque": 5,
}  # fmt: skip
RATES = {"cables": 1, "chambers": 3, "drives": 0}
EFFORTS = {"cable": 4, "chamber": 2, "drive": 5}
POSITIONS = {"cable": 1, "chamber": 3, "drive": 0}


def scaled(value: Any, s: float, table: str, folder: Path) -> Any:
    """What a robot file says, s times as large.

    Args:
        value: a table, a list or a number.
        s: ratio of lengths.
        table: name of the table that it is in.
        folder: where meshes are written.
    """
    if isinstance(value, list):
        return [scaled(one, s, table, folder) for one in value]
    if not isinstance(value, dict):
        return value
    found = {}
    for name, given in value.items():
        power = RATES[table] if name == "max_rate" else POWERS.get(name)
        if name == "file":
            mesh = meshio.read(shipped_folder() / given)
            mesh.points *= s
            meshio.write(folder / given, mesh)
            found[name] = str(folder / given)
        elif power is None or isinstance(given, str):
            found[name] = scaled(given, s, name if table != "contacts" else table, folder)
        else:
            found[name] = (s**power * np.array(given)).tolist()
    return found


def decided(name: str, s: float, folder: Path) -> tuple[list[str], Array, Array]:
    """Kinds of the actuators, positions and efforts (steps, n_a) of a robot s times as large, in its unit."""
    folder.mkdir()
    contents = tomllib.loads((shipped_folder() / f"{name}.toml").read_text(encoding="utf-8"))
    larger = scaled(contents, s, "", folder)
    larger["controller"].pop("basis", None)
    setup = controller_setup(
        larger, folder / f"{name}.toml", basis="none", model="full", young_scale=s**2
    )
    controller = Controller(setup.robot, setup.contact, settings=setup.controller)
    assert controller.settle_start().converged
    kinds = [kind.value for kind in controller.robot.actuators.kinds]
    positions, efforts, rng = [], [], np.random.default_rng(3)
    layout, start = controller.robot.effector_layout, controller.effector_values
    for _ in range(4):
        way = 0.002 * s * rng.standard_normal(len(layout.units)) / layout.units
        actuation = controller.step(layout.moved(start, way))
        assert actuation.status.usable
        positions.append(actuation.position / [s ** POSITIONS[kind] for kind in kinds])
        efforts.append(actuation.effort / [s ** EFFORTS[kind] for kind in kinds])
    return kinds, np.array(positions), np.array(efforts)


ROBOTS = [
    ("gripper", 4.0),
    *(
        pytest.param(name, s, marks=pytest.mark.slow)
        for name in ("diamond", "tripod", "pneumatic_finger")
        for s in (4.0, 0.25)
    ),
]


@pytest.mark.long
@pytest.mark.parametrize(("name", "s"), ROBOTS)
def test_a_robot_of_another_size_does_the_same(name: str, s: float, tmp_path: Path) -> None:
    kinds, position, effort = decided(name, 1.0, tmp_path / "as_shipped")
    again, larger_position, larger_effort = decided(name, s, tmp_path / "scaled")
    assert kinds == again
    assert np.abs(position).max() > 0.0
    np.testing.assert_allclose(larger_position, position, atol=1e-7 * np.abs(position).max())
    np.testing.assert_allclose(larger_effort, effort, atol=1e-7 * np.abs(effort).max())


def settled_crawler(s: float, folder: Path) -> tuple[Array, Array]:
    """Foot (3,) and tensions (2,) of the crawler at rest on its floor, s times as large, in its unit."""
    contents = tomllib.loads((EXAMPLES / "crawler.toml").read_text(encoding="utf-8"))
    (body,) = contents.pop("bodies")
    contents |= {
        "gravity": [0.0, 0.0, -9.81],
        "contact": {"alarm_distance": 2e-3, "tolerance": 5e-5},
    }
    mesh, file = meshio.read(EXAMPLES / body["mesh"]["file"]), folder / f"{s}.vtu"
    mesh.points *= s
    meshio.write(file, mesh)
    larger = scaled(contents, s, "", folder)
    larger["bodies"] = [{**body, "mesh": {**body["mesh"], "file": str(file)}}]
    simulator = Simulator(make_robot(larger, folder / "crawler.toml", Changes(young_scale=s**2)))
    assert simulator.settle(position=[0.0, 0.0]).converged
    return simulator.effector[0] / s, simulator.effort / s**4


@pytest.mark.long
@pytest.mark.parametrize("s", [0.0625, 16.0])
def test_a_robot_of_another_size_settles_as_near_to_equilibrium(s: float, tmp_path: Path) -> None:
    """Tensions of the smaller one were 5e-4 away, as its last step was to be shorter than 1e-7 m."""
    foot, tension = settled_crawler(1.0, tmp_path)
    other_foot, other_tension = settled_crawler(s, tmp_path)
    assert tension.max() > 0.0
    np.testing.assert_allclose(other_foot, foot, atol=1e-8)
    np.testing.assert_allclose(other_tension, tension, atol=1e-4 * tension.max())
