"""Robots of SoftRobots, built from the models that SOFA computed with (reference data README)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tauten.model import Robot
from tauten.model.load import build_robot
from tauten.model.mesh import checked
from tauten.model.schema import RobotConfig
from tauten.model.tetra import NodalBody

MM = 1e-3


def robots_folder(reference: Path, needed: str) -> Path:
    """The folder of robots that SOFA computed; the test is skipped where a file that it needs is missing."""
    folder = reference / "sofa_robots"
    if not (folder / needed).is_file():
        pytest.skip(f"no robots computed by SOFA in {folder}")
    return folder


def pneumatic_finger(data: Path) -> Robot[NodalBody]:
    """The PneuNet gripper finger: 376 nodes, one cavity, a stiff layer."""
    model = np.load(data / "gripperfinger_model.npz")
    nodes, tets = MM * model["nodes"], model["tets"].astype(np.int64)
    stiff = {tuple(sorted(tet)) for tet in model["stiff_tets"].tolist()}
    chosen = np.array([tuple(sorted(tet)) in stiff for tet in tets.tolist()])
    centres = nodes[tets[chosen]].mean(axis=1)
    fixed = nodes[model["fixed"]]
    config = RobotConfig.model_validate(
        {
            "name": "pneumatic_finger",
            "gravity": [0.0, 0.0, 0.0],
            "mesh": {"file": "gripperfinger_model.npz"},
            "material": {"young_modulus": 500e3, "poisson_ratio": 0.3, "density": 1000.0},
            "materials": [
                {
                    "region": {
                        "lower": (centres.min(axis=0) - 1e-6).tolist(),
                        "upper": (centres.max(axis=0) + 1e-6).tolist(),
                    },
                    "young_modulus": 1500e3, "poisson_ratio": 0.3, "density": 1000.0,
                }
            ],
            "fixed": [{"lower": (x - 1e-7).tolist(), "upper": (x + 1e-7).tolist()} for x in fixed],
            "chambers": [
                {
                    "name": "air", "inside": (MM * model["cavity_nodes"]).mean(axis=0).tolist(),
                    "max_pressure": 1.2e5, "max_volume_change": 1e-5, "max_rate": 1e-5,
                }
            ],
            "effectors": [{"name": "tip", "point": (MM * model["tip"][0]).tolist()}],
        }
    )  # fmt: skip
    return build_robot(config, checked(nodes, tets, "gripperfinger"), "gripperfinger")
