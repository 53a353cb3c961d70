"""Rigid links on hinges, pulled by a tendon, against MuJoCo.

`tests/reference/make_mujoco.py` writes its motions: angles of joints are coordinates there, and steps are of
RK4. Here links have the rotations of their frames, bearings that tilt a little, and implicit steps.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from support.robots.bodies import CABLE
from support.robots.joined import joined

from tauten.model import Robot, Simulator

REFERENCE = Path(__file__).parents[2] / "reference"
sys.path.insert(0, str(REFERENCE))
import make_mujoco as scene  # noqa: E402

MOTIONS = json.loads((REFERENCE / "data/mujoco.json").read_text(encoding="utf-8"))["motions"]


def links(case: scene.Case) -> Robot:
    """The robot of a motion."""
    boxes = {"base": ((scene.ROOT, scene.SIDE, scene.SIDE), (1, 1, 1))}
    held = {"rigid": True, "free": True} if case.free else {"fixed": [{"kind": "all"}]}
    bodies: list[dict[str, object]] = [{"name": "base", **held}]
    aside = scene.MIDDLE + case.aside
    hinges, points, x, before = [], [[scene.ON_BASE, aside, scene.HEIGHT]], scene.ROOT, "base"
    for number, (length, axis) in enumerate(zip(scene.LENGTHS, case.axes, strict=True)):
        name = f"link{number}"
        boxes[name] = ((length, scene.SIDE, scene.SIDE), (2, 1, 1))
        bodies.append({"name": name, "rigid": True, "position": [x, 0.0, 0.0]})
        hinges.append({
            "kind": "hinge", "region": {"kind": "all", "body": name}, "to": {"kind": "all", "body": before},
            "axis": list(axis), "through": [x, scene.MIDDLE, scene.MIDDLE],
        })  # fmt: skip
        points += [[x + share * length, aside, scene.HEIGHT] for share in scene.ON_LINKS]
        x, before = x + length, name
    tendon = {**CABLE, "points": points, "min_pull": -1.0, "max_pull": 1.0}
    if case.stiffness:
        tendon["spring"] = {"stiffness": case.stiffness}
    return joined(
        bodies, boxes, gravity=list(case.gravity), attachments=hinges, cables=[tendon],
        effectors=[{"name": "tip", "point": [x, scene.MIDDLE, scene.MIDDLE]}],
        integration={"scheme": "implicit-euler"}, controller={"rate": 1.0 / scene.PERIOD},
    )  # fmt: skip


def error(name: str, steps: int, periods: int) -> float:
    """Largest distance of the tip from where MuJoCo has it, at the ends of periods in some steps each [m]."""
    case, tips = scene.CASES[name], []
    simulator = Simulator(links(case), contact="none")
    for number in range(periods):
        if case.stiffness:
            simulator.move(position=[scene.PERIOD * case.winch * (number + 1)], steps=steps)
        else:
            simulator.move(effort=[case.tension], steps=steps)
        tips.append(simulator.effector[0])
    return float(np.linalg.norm(np.array(tips) - MOTIONS[name][:periods], axis=1).max())


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "nearest"), [("plane_falls", 1e-4), ("plane_tension", 1e-4), ("plane_free", 3e-4)]
)
def test_links_in_a_plane_move_to_second_order(name: str, nearest: float) -> None:
    """Half a second, in which they turn over."""
    coarse, fine = error(name, 8, 25), error(name, 16, 25)
    assert fine < nearest
    assert coarse > 3.5 * fine


@pytest.mark.long
@pytest.mark.parametrize("name", ["falls", "oblique", "winch", "free"])
def test_links_on_axes_that_cross_move_as_in_mujoco(name: str) -> None:
    """Bearings that are nearly rigid are loaded there, for which two-stage steps are of first order."""
    coarse, fine = error(name, 16, 10), error(name, 32, 10)
    assert fine < 2e-4
    assert coarse > 1.9 * fine
