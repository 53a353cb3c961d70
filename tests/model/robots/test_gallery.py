"""The gallery: scripts make the shipped files, robots load by name, their models fit them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.robots.gallery import ROBOTS
from tauten.model import Simulator, load_robot
from tauten.model.mesh import mean_ratios, part_numbers, read_mesh
from tauten.model.tetra import NodalBody
from tauten.service.setup import load_setup

SHIPPED = Path(__file__).resolve().parents[3] / "model" / "robots"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("gallery")
    for make in ROBOTS.values():
        make(folder)
    return folder


@pytest.mark.parametrize("name", ROBOTS)
def test_scripts_make_the_shipped_robots(made: Path, name: str) -> None:
    for file in made.glob(f"{name}*"):
        if file.suffix == ".vtu":
            old, new = read_mesh(SHIPPED / file.name), read_mesh(file)
            np.testing.assert_array_equal(old.tets, new.tets)
            np.testing.assert_allclose(old.nodes, new.nodes, rtol=0.0, atol=1e-15)
        else:
            assert file.read_bytes() == (SHIPPED / file.name).read_bytes()


@pytest.mark.parametrize("name", ROBOTS)
def test_meshes_are_good(made: Path, name: str) -> None:
    for file in made.glob(f"{name}*.vtu"):
        mesh = read_mesh(file)
        assert mean_ratios(mesh).min() > 0.15
        assert part_numbers(mesh.tets).max() == 0


@pytest.mark.parametrize("name", ROBOTS)
def test_they_load_by_name_with_what_they_need(name: str) -> None:
    setup = load_setup(name)
    assert setup.robot.name == name
    robot = load_robot(name)
    assert isinstance(robot.body, NodalBody) or name in ("tripod", "gripper")
    assert Simulator(robot).settle(effort=np.zeros(robot.n_a)).converged
