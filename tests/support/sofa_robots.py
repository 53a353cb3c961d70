"""Robots of SoftRobots, built from the models that SOFA computed with (reference data README)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tauten.model.constraints import ConstrainedRobot
from tauten.model.load import build_robot
from tauten.model.mesh import checked
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig
from tauten.model.tetra import TetRobot

TRUNK_CABLES = ("L0", "L1", "L2", "L3", "S0", "S1", "S2", "S3")
MM = 1e-3


def trunk(
    data: Path, cables: tuple[str, ...] = TRUNK_CABLES, gravity: tuple[float, ...] = (0.0, 0.0, 0.0)
) -> TetRobot:
    """The trunk: 709 nodes, up to 8 cables, fixed in its lowest 20 mm."""
    model = np.load(data / "trunk_model.npz")
    rows = [
        {"name": name, "points": MM * model[f"cable_{name}_pts"], "max_pull": 0.05}
        for name in cables
    ]
    tip = MM * model["tip"][0]
    return _built("trunk", model, rows, tip, (450e3, 0.042), gravity)


def diamond(data: Path, gravity: tuple[float, ...] = (0.0, 0.0, -9.81)) -> TetRobot:
    """The diamond: 1,628 nodes, one cable to each of its four legs."""
    model = np.load(data / "diamond_model.npz")
    rows = [
        {"name": name, "pull_point": MM * pull, "points": MM * point[None], "max_pull": 0.04}
        for name, pull, point in zip(
            ("north", "west", "south", "east"), model["pull"], model["pts"][1:5], strict=True
        )
    ]
    return _built("diamond", model, rows, MM * model["pts"][0], (180e3, 0.5), gravity)


def tripod(data: Path) -> ConstrainedRobot:
    """The tripod: 235 nodes, three servos that turn the ends of its legs; nothing else holds it."""
    model = np.load(data / "tripod_low_model.npz")
    nodes = MM * model["nodes"]

    def around(ids: Array) -> dict[str, Any]:
        boxes = [{"lower": nodes[i] - 1e-7, "upper": nodes[i] + 1e-7} for i in ids]
        return {"kind": "union", "of": [{k: box[k].tolist() for k in box} for box in boxes]}

    drives = [
        {
            "name": f"servo{arm}",
            "region": around(model[f"arm{arm}"]),
            "axis": model["axes"][arm].tolist(),
            "through": (MM * model["servo"][arm]).tolist(),
            "max_angle": 1.5,
            "max_torque": 5.0,
            "max_rate": 10.0,
        }
        for arm in range(3)
    ]
    centre = {"name": "centre", "kind": "centre", "region": around(model["centre"])}
    plate = {"name": "plate", "kind": "frame", "region": around(model["centre"])}
    config = RobotConfig.model_validate(
        {
            "name": "tripod",
            "gravity": [0.0, -9.81, 0.0],
            "mesh": {"file": "tripod_low_model.npz"},
            "material": {"young_modulus": 250e3, "poisson_ratio": 0.45, "total_mass": 0.032},
            "drives": drives,
            "effectors": [centre, plate],
        }
    )
    mesh = checked(nodes, model["tets"].astype(np.int64), "tripod")
    robot = build_robot(config, mesh, "tripod")
    assert isinstance(robot, ConstrainedRobot)
    raw = replace(robot.raw, mass=np.full(robot.raw.n, 0.032 / robot.n_nodes))  # as SOFA has it
    return replace(robot, raw=raw).loaded(np.array(config.gravity), np.zeros(6))


def _built(
    name: str, model: Any, cables: list[dict[str, Any]], tip: Array,
    stiffness_and_mass: tuple[float, float], gravity: tuple[float, ...],
) -> TetRobot:  # fmt: skip
    """A robot in metres with the same mass on every node, as SOFA has it."""
    nodes, fixed = MM * model["nodes"], MM * model["nodes"][model["fixed"]]
    boxes = [{"lower": point - 1e-7, "upper": point + 1e-7} for point in fixed]
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
                "young_modulus": young_modulus, "poisson_ratio": 0.45, "density": 1000.0
            },
            "fixed": [{key: box[key].tolist() for key in box} for box in boxes],
            "cables": cables,
            "effectors": [{"name": "tip", "point": tip.tolist(), "max_outside": 5e-3}],
        }
    )  # fmt: skip
    robot = build_robot(config, checked(nodes, model["tets"].astype(np.int64), name), name)
    robot = replace(robot, mass=np.full(robot.n, mass / robot.n_nodes))
    return robot.loaded(np.array(gravity), np.zeros(3))


def pneumatic_finger(data: Path) -> TetRobot:
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
