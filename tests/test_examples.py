"""The examples run, and the numbers they assert hold."""

from __future__ import annotations

import runpy
from pathlib import Path

import meshio
import numpy as np
import pytest

from benchmarks.robots.grasping import MESHES
from tauten.model import Simulator, load_robot
from tauten.service.describing import describe
from tauten.service.setup import load_setup

EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("[0-9]*.py"))


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_it_runs(example: Path) -> None:
    needs_its_libraries(example)
    runpy.run_path(str(example), run_name="__main__")


def needs_its_libraries(example: Path) -> None:
    """Skip a test where MuJoCo is needed and not installed."""
    if "import mujoco" in example.read_text(encoding="utf-8"):
        pytest.importorskip("mujoco", reason=f"{example.name} needs the package mujoco")


@pytest.mark.long
def test_mujoco_as_a_driver_bends_the_arm_as_far_as_its_model() -> None:
    """By 0.13 m, 2.2 mm apart: its tendons stretch by 7.2 N / 2e4 N/m, its links are not compressed."""
    example, pulled = EXAMPLES[0].with_name("15_mujoco.py"), np.array([0.015, -0.0075, -0.0075])
    needs_its_libraries(example)
    program = runpy.run_path(str(example))
    arm = program["Arm"]()
    arm.configure(describe(load_setup(program["FILE"])), {})
    model = Simulator(load_robot(program["FILE"]))
    for pull in (np.zeros(3), pulled):
        arm.write(pull, np.zeros(3))
        for _ in range(40):  # 4 s
            arm.begin -= 0.1
            measured = arm.read()
        assert model.settle(position=pull).converged
        assert np.linalg.norm(measured.effectors - model.tip) < 2.5e-3
        np.testing.assert_allclose(measured.effort, model.effort, rtol=0.02, atol=1e-6)
        np.testing.assert_allclose(measured.position[0], pull[0], atol=4e-4)


def test_meshes_are_those_that_their_script_makes(tmp_path: Path) -> None:
    for make in MESHES.values():
        make(tmp_path)
    made = sorted(tmp_path.glob("*.vtu"))
    assert made
    for path in made:
        kept, new = meshio.read(EXAMPLES[0].with_name(path.name)), meshio.read(path)
        np.testing.assert_allclose(kept.points, new.points, atol=1e-9)
        np.testing.assert_array_equal(kept.cells_dict["tetra"], new.cells_dict["tetra"])
