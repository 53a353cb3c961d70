"""Robots small enough for campaigns in seconds: a thumb with two notches, a finger with a coarse mesh."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import meshio

from benchmarks.robots.make_finger import COARSE, FingerShape, make_finger
from tauten.model import Robot
from tauten.model.load import build_robot, robot_path
from tauten.model.mesh import TetMesh
from tauten.model.schema import RobotConfig, model_tables, read_toml, validated
from tauten.model.tetra import NodalBody


def thumb_mesh() -> TetMesh:
    """Its mesh."""
    return TetMesh(
        *make_finger(
            FingerShape(
                length=0.05,
                root=0.0004,
                slope=0.064,
                blocks=3,
                insert=0.040,
                below=(0.0, 1.0),
                above=(0.010, 0.015),
                across=2,
                along=(0.0, 0.5, 1.0),
                first=(0.0, 0.5, 1.0),
                last=(0.0, 1.0),
                end=1,
            )
        )
    )


def coarse_finger_mesh() -> TetMesh:
    """The shape of the shipped finger with few, large tetrahedra."""
    return TetMesh(*make_finger(COARSE))


def coarse_finger() -> Robot[NodalBody]:
    """The shipped finger on a coarse mesh of linear elements: too stiff, otherwise the same."""
    path = robot_path("finger")
    config = validated(RobotConfig, model_tables(read_toml(path)), path).with_element("linear")
    robot = build_robot(config, coarse_finger_mesh(), str(path))
    assert isinstance(robot.body, NodalBody)
    return robot


def write_coarse_finger(folder: Path) -> Path:
    """File and mesh of the shipped finger on a coarse mesh, without its bases; returns the file."""
    mesh = coarse_finger_mesh()
    meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]).write(folder / "finger.vtu")
    lines = robot_path("finger").read_text().splitlines(keepends=True)
    kept = [line for line in lines if not line.startswith(("basis =", "states =", "order ="))]
    file = folder / "finger.toml"
    file.write_text("".join(kept))
    return file


def thumb_settings() -> dict[str, Any]:
    """Its robot file."""
    pitch = 0.05 / 3.0
    surfaces, contacts = [], []
    for notch in (1, 2):
        z = -notch * pitch
        box = {"lower": [0.010, 0.0, z - 0.002], "upper": [0.015, 0.015, z + 0.002]}
        for side, normal in (("above", [0.0, 0.0, -1.0]), ("below", [0.0, 0.0, 1.0])):
            surfaces.append({"name": f"notch{notch}_{side}", "box": box, "normal": normal})
        contacts.append(
            {"candidates": f"notch{notch}_below", "against": f"notch{notch}_above", "points": 24}
        )
    return {
        "name": "thumb",
        "mesh": {"file": "thumb.vtu"},
        "material": {"young_modulus": 0.6e6, "poisson_ratio": 0.45, "density": 1100.0},
        "fixed": [{"lower": [0.0, 0.0, 0.0], "upper": [0.015, 0.015, 0.0]}],
        "cables": [
            {
                "name": "tendon",
                "points": [[0.011, 0.0075, -0.002], [0.011, 0.0075, -0.048]],
                "max_tension": 20.0,
                "max_pull": 0.008,
                "max_rate": 0.04,
            }
        ],
        "effectors": [{"name": "tip", "point": [0.0075, 0.0075, -0.05]}],
        "surfaces": surfaces,
        "contacts": contacts,
        "integration": {"scheme": "quasi-static"},
        "controller": {"rate": 50.0},
    }


def write_thumb(folder: Path) -> Path:
    """File and mesh in a folder; returns the file."""
    mesh = thumb_mesh()
    meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]).write(folder / "thumb.vtu")
    file = folder / "thumb.toml"
    file.write_text("".join(f"{key} = {_toml(value)}\n" for key, value in thumb_settings().items()))
    return file


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return json.dumps(value)  # numbers and strings look the same in both
