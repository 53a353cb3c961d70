"""Boxes of tetrahedra and robots made of them, for tests that need a body of their own."""

from __future__ import annotations

import numpy as np

from tauten.model.load import build_robot
from tauten.model.mesh import TetMesh, oriented
from tauten.model.numerics import Array, Ints
from tauten.model.robots.make_finger import split_cells
from tauten.model.schema import RobotConfig
from tauten.model.tetra import TetRobot


def box_mesh(size: tuple[float, float, float], cells: tuple[int, int, int]) -> TetMesh:
    """A box from the origin, six tetrahedra a cell."""
    axes = [np.linspace(0.0, length, m + 1) for length, m in zip(size, cells, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    nodes: Array = grid.reshape(-1, 3)
    numbers: Ints = np.arange(len(nodes)).reshape(grid.shape[:3])
    return TetMesh(nodes, oriented(nodes, split_cells(numbers, mirror_from=cells[1])))


def beam_config(size: tuple[float, float, float], **changes: object) -> dict[str, object]:
    """Settings of a beam along x, held at x = 0, one cable along its lower side."""
    length, width, height = size
    middle = 0.5 * width
    settings: dict[str, object] = {
        "name": "beam",
        "mesh": {"file": "beam.vtu"},
        "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0},
        "fixed": [{"lower": [0.0, 0.0, 0.0], "upper": [0.0, width, height]}],
        "gravity": [0.0, 0.0, 0.0],
        "cables": [
            {
                "name": "tendon",
                "points": [[0.1 * length, middle, 0.1 * height], [length, middle, 0.1 * height]],
                "max_tension": 100.0,
                "max_pull": 0.5 * length,
                "max_rate": length,
            }
        ],
        "effectors": [{"name": "tip", "point": [length, middle, 0.5 * height]}],
        "integration": {"scheme": "implicit-euler"},
        "controller": {"rate": 100.0},
    }
    settings.update(changes)
    return settings


def beam_robot(mesh: TetMesh, size: tuple[float, float, float], **changes: object) -> TetRobot:
    """A robot made of a beam."""
    config = RobotConfig.model_validate(beam_config(size, **changes))
    return build_robot(config, mesh, "beam")
