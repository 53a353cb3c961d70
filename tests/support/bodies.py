"""Boxes of tetrahedra and robots made of them or of beams, with effectors of every kind."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from support.beam_robots import build, cable, path_of_beams, rectangle
from tauten.model import Robot, State
from tauten.model.beams import BeamRobot
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


SIZE = (0.1, 0.02, 0.02)
END = {"lower": [0.09, -1.0, -1.0], "upper": [1.0, 1.0, 1.0]}
ALL_KINDS: list[dict[str, Any]] = [
    {"name": "tip", "point": [0.1, 0.01, 0.01]},
    {"name": "tool", "kind": "frame", "region": END, "point": [0.12, 0.0, 0.01]},
    {"name": "middle", "kind": "centre", "region": END},
    {"name": "span", "kind": "distance", "point": [0.1, 0.0, 0.0], "other": [0.02, 0.0, 0.02]},
    {
        "name": "sensor",
        "kind": "length",
        "points": [[0.03, 0.01, 0.002], [0.06, 0.01, 0.02], [0.1, 0.0, 0.0]],
        "pull_point": [-0.01, 0.0, 0.01],
    },
    {"name": "room", "kind": "volume", "inside": [0.05, 0.01, 0.01]},
]


def hollow_mesh() -> TetMesh:
    """A box with a cavity from 0.02 to 0.08 m, 0.01 m wide and high."""
    mesh = box_mesh(SIZE, (5, 4, 4))
    centres = mesh.nodes[mesh.tets].mean(axis=1)
    within = (np.abs(centres - [0.05, 0.01, 0.01]) < [0.03, 0.005, 0.005]).all(axis=1)
    used, corners = np.unique(mesh.tets[~within], return_inverse=True)
    return TetMesh(mesh.nodes[used], corners.reshape(-1, 4))


def solid(effectors: list[dict[str, Any]] | None = None) -> TetRobot:
    """A beam of tetrahedra along x, held at x = 0."""
    return beam_robot(hollow_mesh(), SIZE, effectors=effectors or ALL_KINDS)


def beams(folder: Path, effectors: list[dict[str, Any]]) -> BeamRobot:
    """A cantilever of five beams along x, with a disc on each node."""
    nodes = np.linspace([0.0, 0.0, 0.0], [0.5, 0.0, 0.0], 6)
    structure = path_of_beams(nodes, (0.0, 0.0, 1.0), "strip")
    profile = rectangle("strip", 0.02, 0.002)
    return build(
        folder, nodes, structure, [profile], (1e9, 0.3, 1000.0), [0], 5,
        cables=[cable([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]])], effectors=effectors,
    )  # fmt: skip


BEAM_KINDS: list[dict[str, Any]] = [
    {"name": "tip", "point": [0.5, 0.0, 0.0], "max_outside": 1.0},
    {"name": "tool", "kind": "frame", "point": [0.55, 0.01, 0.0], "max_outside": 1.0},
    {
        "name": "middle",
        "kind": "centre",
        "region": {"lower": [0.25, -1.0, -1.0], "upper": [1.0, 1.0, 1.0]},
    },
    {
        "name": "span",
        "kind": "distance",
        "point": [0.0, 0.0, 0.0],
        "other": [0.5, 0.02, 0.0],
        "max_outside": 1.0,
    },
    {
        "name": "sensor",
        "kind": "length",
        "points": [[0.0, 0.01, 0.0], [0.5, 0.01, 0.0]],
        "max_outside": 1.0,
    },
]


def disturbed(robot: Robot, rng: np.random.Generator, size: float) -> State:
    """A state away from rest, reached by a velocity that bends and turns."""
    state = robot.rest()
    for _ in range(3):
        state = moved(robot, state, size * rng.standard_normal(robot.n))
    return state


def moved(robot: Robot, state: State, dq: Array) -> State:
    """The state after a change dq (n,) of the configuration."""
    still = State(state.q, np.zeros(robot.n))
    system = robot.linearise(still)
    return robot.advance(still, system, dq / system.h - system.v)
