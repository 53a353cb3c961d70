"""Robots with effectors of every kind, and small motions of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from support.robots.beam_robots import build, cable, path_of_beams, rectangle
from support.robots.bodies import beam_robot, box_mesh
from tauten.model import Robot, State
from tauten.model.beams import BeamBody
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array
from tauten.model.tetra import NodalBody

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


def solid(effectors: list[dict[str, Any]] | None = None) -> Robot[NodalBody]:
    """A beam of tetrahedra along x, held at x = 0."""
    return beam_robot(hollow_mesh(), SIZE, effectors=effectors or ALL_KINDS)


def beams(folder: Path, effectors: list[dict[str, Any]]) -> Robot[BeamBody]:
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
        "name": "plate",
        "kind": "frame",
        "region": {"lower": [0.25, -1.0, -1.0], "upper": [1.0, 1.0, 1.0]},
    },
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
    return robot.advance(state, dq, 1.0)
