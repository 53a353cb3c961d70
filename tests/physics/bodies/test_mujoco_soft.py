"""Soft bodies in motion against MuJoCo: one that bends, one that twists, one that nothing holds.

`tests/reference/make_mujoco_soft.py` writes its motions. Its law is that of Saint Venant and Kirchhoff, from
which the corotational one differs by the strain: motions are near each other, not the same.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from support.robots.bodies import beam_config

from tauten.model import Robot, Simulator, State
from tauten.model.load import build_robot
from tauten.model.schema import RobotConfig

REFERENCE = Path(__file__).parents[2] / "reference"
sys.path.insert(0, str(REFERENCE))
import make_mujoco_soft as scene  # noqa: E402

MOTIONS = json.loads((REFERENCE / "data/mujoco_soft.json").read_text(encoding="utf-8"))["motions"]


def soft(case: scene.Case) -> Robot:
    """The robot of a motion; its cable pulls nothing."""
    body = {"name": "box", "mesh": {"file": "box.vtu"}, "free": not case.held}
    settings = beam_config(
        case.size, mesh=None, bodies=[body], controller={"rate": 1.0 / scene.PERIOD},
        material={"young_modulus": case.young_modulus, "poisson_ratio": scene.POISSON_RATIO,
                  "density": scene.DENSITY},
        effectors=[{"name": "tip", "point": case.mesh.nodes[-1].tolist()}],
    )  # fmt: skip
    if not case.held:
        settings["fixed"] = []
    known = {key: value for key, value in settings.items() if value is not None}
    return build_robot(RobotConfig.model_validate(known), [case.mesh], "box")


def error(name: str, steps: int) -> float:
    """Largest distance of the tip from where MuJoCo has it, at the ends of periods in some steps each [m]."""
    case, tips = scene.CASES[name], []
    simulator = Simulator(soft(case), contact="none")
    v = case.velocity[case.free].ravel()
    simulator.start_from(State(simulator.state.q, v))
    for _ in range(scene.PERIODS):
        simulator.move(effort=[0.0], steps=steps)
        tips.append(simulator.effector[0])
    return float(np.linalg.norm(np.array(tips) - MOTIONS[name], axis=1).max())


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "nearest"), [("bends", 4e-5), ("twists", 1e-4), ("tumbles", 4e-4)]
)
def test_soft_bodies_move_as_in_mujoco(name: str, nearest: float) -> None:
    """A third of a second; the tip of the one that tumbles goes 3 cm to and fro in more than a turn."""
    coarse, fine = error(name, 4), error(name, 8)
    assert fine < nearest
    assert coarse > 2.5 * fine
