"""PneuNets and accordion of SoftRobots, which SOFA gives no curve of, from the models that it loads."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from support.sofa_elements import MM, points_as_in_sofa
from tauten.model.constraints import ConstrainedRobot, GluedNodes
from tauten.model.load import actuators, build_robot
from tauten.model.load import robot as robot_module
from tauten.model.load.constraints import Constraints
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig


def around(points: Array) -> dict[str, Any]:
    """The region of given nodes (k, 3) [m]."""
    boxes = [
        {"kind": "box", "lower": (x - 1e-8).tolist(), "upper": (x + 1e-8).tolist()} for x in points
    ]
    return {"kind": "union", "of": boxes}


def pneunets(data: Path) -> ConstrainedRobot:
    """1,214 nodes, one chamber, one element of the stiff layer."""
    model = np.load(data / "pneunets_model.npz")
    nodes = MM * model["nodes"]
    centre = nodes[model["stiff_tets"][0]].mean(axis=0)
    config = RobotConfig.model_validate(
        {
            "name": "pneunets",
            "gravity": [0.0, 0.0, 0.0],
            "mesh": {"file": "pneunets_model.npz"},
            "material": {"young_modulus": 100e3, "poisson_ratio": 0.3, "density": 1000.0},
            "materials": [
                {
                    "region": {"kind": "sphere", "centre": centre.tolist(), "radius": 1e-7},
                    "young_modulus": 300e3, "poisson_ratio": 0.3, "density": 1000.0,
                }
            ],
            "fixed": [around(nodes[model["fixed"]])],
            "chambers": [
                {
                    "name": "air", "inside": [0.0, 0.0, 0.0],
                    "max_pressure": 1e4, "max_volume_change": 2e-5, "max_rate": 5e-5,
                }
            ],
            "effectors": [{"name": "tip", "point": (MM * model["tip"][0]).tolist()}],
        }
    )  # fmt: skip
    return built(config, model, "tip")


def accordion(data: Path) -> ConstrainedRobot:
    """1,532 nodes, three cables and a chamber.

    Tetrahedra of this mesh occupy the same space, so that its own boundary is not closed around the chamber.
    """
    model = np.load(data / "accordion_model.npz")
    nodes = MM * model["nodes"]
    cables = [
        {
            "name": f"cable{i}", "pull_point": (MM * model["pull"][i - 1]).tolist(),
            "points": (MM * model[f"cable{i}_pts"]).tolist(),
            "max_tension": 1.0, "max_pull": 2e-3, "max_rate": 0.02,
        }
        for i in (1, 2, 3)
    ]  # fmt: skip
    air = {"name": "air", "inside": [0.0, 0.0, 0.0], "min_pressure": -5e3, "max_pressure": 2e4,
           "max_volume_change": 5e-9, "max_rate": 5e-8}  # fmt: skip
    config = RobotConfig.model_validate(
        {
            "name": "accordion",
            "gravity": [0.0, 0.0, 0.0],
            "mesh": {"file": "accordion_model.npz"},
            "material": {"young_modulus": 500e3, "poisson_ratio": 0.3, "density": 1000.0},
            "fixed": [around(nodes[model["fixed"]])],
            "cables": cables,
            "chambers": [air],
            "effectors": [{"name": "top", "kind": "centre", "region": around(nodes[model["top"]])}],
        }
    )
    return built(config, model, "cable1", "cable2", "cable3")


def built(config: RobotConfig, model: Any, *points: str) -> ConstrainedRobot:
    """A robot whose chamber has the surface of SOFA, which follows the elements that SOFA maps it to.

    The triangles of that surface are not those of the mesh.

    Args:
        config: its file; where its chamber lies does not matter.
        model: a `*_model.npz` of the reference data.
        points: names of the points of its cables and effectors.
    """
    count, tets = len(model["nodes"]), model["tets"].astype(np.int64)
    nodes = MM * np.concatenate([model["nodes"], model["cavity_nodes"]])
    surface = count + model["cavity_triangles"].astype(np.int64)
    extra = count + np.arange(len(model["cavity_nodes"]))
    glued = GluedNodes(extra, tets[model["cavity_tet"]], model["cavity_w"])
    none = sp.csr_array((0, 3 * len(nodes)))
    mapped = Constraints(rigid=[], pinned=[], drives=[], glued=glued, springs=none)
    with pytest.MonkeyPatch.context() as patch, points_as_in_sofa(model, *points):
        patch.setattr(actuators, "build_chamber", lambda item, selector: surface)
        patch.setattr(robot_module, "build_constraints", lambda config, bodies: mapped)
        robot = build_robot(config, TetMesh(nodes, tets), config.name)
    assert isinstance(robot, ConstrainedRobot)
    return robot
