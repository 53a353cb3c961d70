"""A soft block on a floor that is an obstacle."""

from __future__ import annotations

from typing import Any

from support.robots.bodies import box_mesh
from tauten.model import Robot, Simulator
from tauten.model.load import build_robot
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig, validated

EVERYWHERE = {"lower": [-1.0, -1.0, -1.0], "upper": [1.0, 1.0, 1.0]}
BELOW = {"name": "below", "box": EVERYWHERE, "normal": [0.0, 0.0, -1.0]}


def block(cells: int = 2, **changes: Any) -> Robot:
    """A soft block that nothing holds, 2 cm a side, on a floor; a force that nobody uses."""
    push = {
        "name": "push", "region": {"kind": "all"}, "direction": [1.0, 0.0, 0.0],
        "max_force": 1.0, "max_travel": 1e3, "max_rate": 1e3,
    }  # fmt: skip
    settings = {
        "name": "block", "forces": [push], "surfaces": [BELOW],
        "material": {"young_modulus": 1e5, "poisson_ratio": 0.3, "density": 1000.0},
        "bodies": [{"name": "cube", "mesh": {"file": "cube.vtu"}, "free": True}],
        "effectors": [{"name": "centre", "kind": "centre", "region": {"kind": "all"}}],
        "contacts": [{"candidates": "below", "against": "floor", "points": "vertices"}],
        "obstacles": [{"name": "floor", "shape": "plane",
                       "parameters": {"point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]}}],
        "integration": {"rayleigh_stiffness": 0.05}, "controller": {"rate": 100.0}, **changes,
    }  # fmt: skip
    cube = box_mesh((0.02, 0.02, 0.02), (cells, cells, cells))
    return build_robot(validated(RobotConfig, settings, "block.toml"), [cube], "block.toml")


def force_on(simulator: Simulator) -> Array:
    """Sum of all contact forces (3,) [N]."""
    found: Array = simulator.contact_forces.sum(axis=0)
    return found
