"""Trunk, diamond and finger of SoftRobots, on the meshes that SOFA computed with.

They are reference data of the project, not part of it: `sofa_robots/trunk_model.npz`,
`sofa_robots/diamond_model.npz` and `softrobots_finger.vtk`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tauten.model import Robot
from tauten.model.load import build_robot
from tauten.model.mesh import checked, read_mesh
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig

TRUNK_CABLES = ("L0", "L1", "L2", "L3", "S0", "S1", "S2", "S3")
FINGER_ROUTE = (
    *((-x, 12.5, 2.5) for x in (17.5, 32.5, 47.5, 62.5, 77.5)),
    *((-83.5, 12.5, 4.5), (-85.5, 12.5, 6.5), (-85.5, 12.5, 8.5), (-83.5, 12.5, 10.5)),
    *((-x, 12.5, 12.5) for x in (77.5, 62.5, 47.5, 32.5, 17.5)),
)  # of its cable [mm]
MM = 1e-3


def trunk(
    data: Path, cables: tuple[str, ...] = TRUNK_CABLES, gravity: tuple[float, ...] = (0.0, 0.0, 0.0)
) -> Robot:
    """The trunk: 709 nodes, up to 8 cables, fixed in its lowest 20 mm.

    Args:
        data: folder of its model.
        cables: which of its cables it has.
        gravity: (3,) [m/s²].
    """
    model = np.load(data / "trunk_model.npz")
    rows = [
        {"name": name, "points": MM * model[f"cable_{name}_pts"], "max_pull": 0.05}
        for name in cables
    ]
    tip = MM * model["tip"][0]
    return _built("trunk", model, rows, tip, (450e3, 0.042), gravity)


def diamond(data: Path, gravity: tuple[float, ...] = (0.0, 0.0, -9.81)) -> Robot:
    """The diamond: 1,628 nodes, one cable to each of its four legs."""
    model = np.load(data / "diamond_model.npz")
    rows = [
        {
            "name": name, "pull_point": MM * position, "points": MM * point[None],
            "min_pull": -0.04, "max_pull": 0.02,
        }
        for name, position, point in zip(
            ("north", "west", "south", "east"), model["pull"], model["pts"][1:5], strict=True
        )
    ]  # fmt: skip
    return _built("diamond", model, rows, MM * model["pts"][0], (180e3, 0.5), gravity)


def finger(data: Path, refinements: int = 0) -> Robot:
    """The finger: 158 nodes, 857 after one refinement, one cable, without gravity.

    Args:
        data: folder of its mesh.
        refinements: how often every tetrahedron is cut into eight.
    """
    mesh = read_mesh(data / "softrobots_finger.vtk", "mm")
    for _ in range(refinements):
        mesh = mesh.refine()
    cable = {
        "name": "tendon", "pull_point": [0.0, 12.5 * MM, 2.5 * MM],
        "points": (MM * np.array(FINGER_ROUTE)).tolist(), "max_outside": 1e-3,
        "max_tension": 10.0, "max_pull": 0.04, "max_rate": 0.1,
    }  # fmt: skip
    config = RobotConfig.model_validate(
        {
            "name": "softrobots_finger",
            "gravity": [0.0, 0.0, 0.0],
            "mesh": {"file": "softrobots_finger.vtk", "length_unit": "mm"},
            "material": {"young_modulus": 600e3, "poisson_ratio": 0.45, "density": 1000.0},
            "fixed": [{"lower": [-0.015, 0.0, 0.0], "upper": [0.005, 0.010, 0.015]}],
            "cables": [cable],
            "effectors": [{"name": "tip", "point": [-0.103, 0.007, 0.007], "max_outside": 1e-3}],
            "integration": {"rayleigh_mass": 0.1, "rayleigh_stiffness": 0.1},
            "controller": {"rate": 100.0},
        }
    )
    return build_robot(config, mesh, "softrobots_finger")


def _built(
    name: str, model: Any, cables: list[dict[str, Any]], tip: Array,
    stiffness_and_mass: tuple[float, float], gravity: tuple[float, ...],
) -> Robot:  # fmt: skip
    """A robot in metres with the same mass on every node, as SOFA has it."""
    young_modulus, mass = stiffness_and_mass
    for cable in cables:
        cable |= {"max_tension": 20.0, "max_rate": 0.1, "max_outside": 5e-3}
        cable["points"] = np.asarray(cable["points"]).tolist()
        if "pull_point" in cable:
            cable["pull_point"] = cable["pull_point"].tolist()
    config = RobotConfig.model_validate(
        {
            "name": name,
            "gravity": list(gravity),
            "mesh": {"file": f"{name}_model.npz"},
            "material": {
                "young_modulus": young_modulus, "poisson_ratio": 0.45,
                "total_mass": mass, "mass": "nodes",
            },
            "fixed": [{"kind": "nodes", "numbers": model["fixed"].tolist()}],
            "cables": cables,
            "effectors": [{"name": "tip", "point": tip.tolist(), "max_outside": 5e-3}],
        }
    )  # fmt: skip
    mesh = checked(MM * model["nodes"], model["tets"].astype(np.int64), name)
    return build_robot(config, mesh, name)
