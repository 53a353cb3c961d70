"""The finger of SoftRobots in two scenes of SOFA: pressed onto a plate, and pulled under gravity."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from support.robots.bodies import box_mesh
from tauten.model.contact import ContactPair, ContactSet
from tauten.model.load import build_robot
from tauten.model.mesh import TetMesh, boundary_triangles
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig
from tauten.model.tetra import TetRobot

MM = 1e-3
NODES, MASS = 158, 0.5  # of the finger; kg, the same on every node
PLATE = 0.039  # m, where the surface of the finger is stopped in y
PLATE_SIZE = (0.2, 0.02, 0.1)  # m


@dataclass(frozen=True, slots=True)
class Scene:
    """What differs between the scenes.

    Attributes:
        young_modulus: [Pa].
        poisson_ratio: of the body.
        gravity: (3,) [m/s²].
    """

    young_modulus: float
    poisson_ratio: float
    gravity: tuple[float, float, float]


def finger_at_plate(data: Path) -> TetRobot:
    """158 nodes and a plate that does not move; the 155 nodes of the surface are the candidates."""
    model = np.load(data / "finger_plate_model.npz")
    own, block = MM * model["nodes"], box_mesh(PLATE_SIZE, (1, 1, 1))
    nodes = np.vstack([own, block.nodes + np.array([-0.15, PLATE, -0.04])])
    mesh = TetMesh(nodes, np.vstack([model["tets"], len(own) + block.tets]).astype(np.int64))
    held = np.concatenate([nodes[model["fixed"]], nodes[len(own) :]])
    robot = _finger(model, model["tip"][0], mesh, held, Scene(600e3, 0.45, (0.0, 0.0, 0.0)))
    faces = boundary_triangles(mesh.tets)
    plate = faces[(faces >= len(own)).all(axis=1)]
    apart = np.linalg.norm(MM * model["col_pts"][:, None] - own[None], axis=2)
    candidates = apart.argmin(axis=1)
    assert apart.min(axis=1).max() < 1e-8
    corners, weights = np.stack([candidates] * 3, axis=1), np.tile([1.0, 0.0, 0.0], (155, 1))
    pair = ContactPair("finger on plate", corners, weights, plate)
    return replace(robot, contacts=ContactSet([pair], len(nodes), 3.0 * MM))


def finger_with_gravity(data: Path) -> TetRobot:
    """The finger 1 mm farther along x, stiffer; its notches, which rub in SOFA, do not touch here."""
    plate = np.load(data / "finger_plate_model.npz")
    model = np.load(data / "finger_selfcontact_model.npz")
    mesh = TetMesh(
        MM * (plate["nodes"] + np.array([1.0, 0.0, 0.0])), plate["tets"].astype(np.int64)
    )
    held, scene = mesh.nodes[model["fixed"]], Scene(18000e3, 0.3, (0.0, -0.981, 0.0))
    return _finger(model, model["tip_pts"][0], mesh, held, scene)


def _finger(model: Any, tip: Array, mesh: TetMesh, held: Array, scene: Scene) -> TetRobot:
    """One cable, masses and points as SOFA has them."""
    cable = {
        "name": "tendon",
        "pull_point": (MM * model["pull"]).tolist(),
        "points": (MM * model["cable_pts"]).tolist(),
        "max_tension": 200.0,
        "max_pull": 0.04,
        "max_rate": 0.1,
    }
    config = RobotConfig.model_validate(
        {
            "name": "softrobots_finger",
            "gravity": list(scene.gravity),
            "mesh": {"file": "finger.npz"},
            "material": {
                "young_modulus": scene.young_modulus, "poisson_ratio": scene.poisson_ratio,
                "density": 1000.0,
            },
            "fixed": [{"lower": (x - 1e-7).tolist(), "upper": (x + 1e-7).tolist()} for x in held],
            "cables": [cable],
            "effectors": [{"name": "tip", "point": (MM * tip).tolist(), "max_outside": 5e-3}],
        }
    )  # fmt: skip
    robot = build_robot(config, mesh, "finger")
    assert isinstance(robot, TetRobot)
    robot = replace(robot, mass=np.full(robot.n, MASS / NODES))
    return robot.loaded(np.array(scene.gravity), np.zeros(3))
