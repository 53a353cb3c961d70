"""Robots with drives, rigid regions and attachments, for tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from support.bodies import beam_config, box_mesh
from tauten.model import State
from tauten.model.constraints import ConstrainedRobot
from tauten.model.load import build_robot
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig, validated

SIZE = (0.1, 0.02, 0.02)
MESH = box_mesh(SIZE, (8, 2, 2))
RUBBER = {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
ROOT = {"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}
END = {"kind": "half_space", "point": [0.0874, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}
MIDDLE = {"lower": [0.037, 0.0, 0.0], "upper": [0.051, 0.02, 0.02]}
TURN = {
    "name": "servo", "axis": [0.0, 1.0, 0.0], "through": [0.045, 0.0, 0.01],
    "max_angle": 3.0, "max_torque": 100.0, "max_rate": 100.0,
}  # fmt: skip
SLIDE = {
    "name": "slider", "motion": "translation", "axis": [0.0, 0.0, 2.0],
    "max_travel": 0.1, "max_force": 100.0, "max_rate": 1.0,
}  # fmt: skip


def constrained(
    meshes: TetMesh | Sequence[TetMesh] = MESH,
    size: tuple[float, float, float] = SIZE,
    **changes: object,
) -> ConstrainedRobot:
    """A beam with constraints; `changes` replace tables of its file, None removes them."""
    settings = {k: v for k, v in beam_config(size, **changes).items() if v is not None}
    robot = build_robot(validated(RobotConfig, settings, "beam.toml"), meshes, "beam.toml")
    assert isinstance(robot, ConstrainedRobot)
    return robot


def rigid_box(**changes: object) -> ConstrainedRobot:
    """The whole beam as one rigid body that nothing holds."""
    body = {"name": "box", "mesh": {"file": "beam.vtu"}, "rigid": True, "free": True}
    return constrained([MESH], mesh=None, bodies=[body], fixed=[], **changes)


@dataclass(frozen=True, slots=True)
class Step:
    """What `advance` reads of a system: a step of one second from standstill."""

    v: Array
    h: float = 1.0


def moved(robot: ConstrainedRobot, state: State, dq: Array) -> State:
    """The state after a change dq (n,) of the coordinates."""
    return robot.advance(state, Step(np.zeros(robot.n)), dq)  # type: ignore[arg-type]
