"""A soft block on a floor that is an obstacle, and bodies that nothing holds."""

from __future__ import annotations

from typing import Any

import numpy as np

from support.robots.bodies import box_mesh
from tauten.model import Robot, Simulator, State
from tauten.model.load import build_robot
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig, validated

DENSITY = 1000.0  # kg/m³
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


def box(
    size: tuple[float, float, float], at: tuple[float, float, float], cells: int = 2
) -> TetMesh:
    """A box whose lowest corner is somewhere [m]."""
    mesh = box_mesh(size, (cells, cells, cells))
    return TetMesh(mesh.nodes + at, mesh.tets)


def touching(candidates: str, against: str, **table: Any) -> dict[str, Any]:
    """A contact of the skin of a body, by default of its vertices."""
    points = {} if "spacing" in table else {"points": "vertices"}
    return {"candidates": candidates, "against": against, **points, **table}


def plane(
    name: str, point: tuple[float, float, float], normal: tuple[float, float, float]
) -> dict[str, Any]:
    """A plane whose frame stands in one of its points."""
    own = {"point": [0.0, 0.0, 0.0], "normal": list(normal)}
    return {"name": name, "shape": "plane", "parameters": own, "position": list(point)}


def free_bodies(
    meshes: dict[str, TetMesh], contacts: list[dict[str, Any]], rate: float, rigid: bool = True,
    **changes: Any,
) -> Robot:  # fmt: skip
    """Bodies without weight that nothing holds; the effectors are their centres.

    The skin of each body has its name, and a force, which may be zero, pushes the first one along x.
    """
    names = list(meshes)
    push = {
        "name": "push", "region": {"kind": "all", "body": f"body_{names[0]}"}, "direction": [1.0, 0.0, 0.0],
        "max_force": 10.0, "max_travel": 1e3, "max_rate": 1e3,
    }  # fmt: skip
    settings = {
        "name": "world", "forces": [push], "contacts": contacts, "gravity": [0.0, 0.0, 0.0],
        "material": {"young_modulus": 1e5, "poisson_ratio": 0.3, "density": DENSITY},
        "bodies": [{"name": f"body_{name}", "mesh": {"file": f"{name}.vtu"}, "free": True, "rigid": rigid}
                   for name in names],
        "regions": [{"name": name, "kind": "skin", "body": f"body_{name}"} for name in names],
        "effectors": [{"name": f"centre_{name}", "kind": "centre",
                       "region": {"kind": "all", "body": f"body_{name}"}} for name in names],
        "contact": {"alarm_distance": 5e-3}, "controller": {"rate": rate}, **changes,
    }  # fmt: skip
    config = validated(RobotConfig, settings, "world.toml")
    return build_robot(config, list(meshes.values()), "world.toml")


def moving(robot: Robot, v: Array) -> Simulator:
    """A simulation from rest in place, with a velocity (n,) [m/s], [rad/s]."""
    simulator = Simulator(robot, "full")
    simulator.start_from(State(simulator.state.q, v, simulator.state.memory))
    return simulator


def velocities(simulator: Simulator) -> Array:
    """Of the effectors: (p, 3) [m/s]."""
    robot, state, seconds = simulator.robot, simulator.state, 1e-6
    after = robot.effector(robot.advance(state, state.v, seconds))
    found: Array = (after - robot.effector(state)) / seconds
    return found


def separation(simulator: Simulator) -> float:
    """Distance of the first two effectors along x [m]."""
    x = simulator.effector[:, 0]
    return float(x[1] - x[0])


def speeds(n: int, along: Array) -> Array:
    """The velocity (6 n,) of n rigid bodies without spin, of which the first has one (3,) [m/s]."""
    v = np.zeros(6 * n)
    v[:3] = along
    return v
