"""The finger of SoftRobots in a scene of SOFA: pulled under gravity."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tauten.model import Robot
from tauten.model.load import build_robot
from tauten.model.mesh import checked
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig
from tauten.model.tetra import NodalBody

MM = 1e-3


def finger_cable(model: Mapping[str, Array]) -> dict[str, object]:
    """The settings of its cable.

    Args:
        model: of a scene, in mm.
    """
    return {
        "name": "tendon",
        "pull_point": (MM * model["pull"]).tolist(),
        "points": (MM * model["cable_pts"]).tolist(),
        "max_tension": 200.0,
        "max_pull": 0.04,
        "max_rate": 0.1,
    }


def finger_with_gravity(data: Path) -> Robot[NodalBody]:
    """The finger 1 mm farther along x, stiffer; its notches, which rub in SOFA, do not touch here."""
    plate = np.load(data / "finger_plate_model.npz")
    model = np.load(data / "finger_selfcontact_model.npz")
    nodes = MM * (plate["nodes"] + np.array([1.0, 0.0, 0.0]))
    tip = (MM * model["tip_pts"][0]).tolist()
    config = RobotConfig.model_validate(
        {
            "name": "softrobots_finger",
            "gravity": [0.0, -0.981, 0.0],
            "mesh": {"file": "finger.npz"},
            "material": {
                "young_modulus": 18e6, "poisson_ratio": 0.3, "total_mass": 0.5, "mass": "nodes",
            },
            "fixed": [{"kind": "nodes", "numbers": model["fixed"].tolist()}],
            "cables": [finger_cable(model)],
            "effectors": [{"name": "tip", "point": tip, "max_outside": 5e-3}],
        }
    )  # fmt: skip
    robot = build_robot(config, checked(nodes, plate["tets"].astype(np.int64), "finger"), "finger")
    assert isinstance(robot.body, NodalBody)
    return robot
