"""Robots made of a few beams, loaded by a force on a node or by a cable, for published benchmarks."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from support.robots.bodies import box_mesh
from tauten.model import Robot, Simulator
from tauten.model.beams import BeamBody, Material, Profile, natural_stiffness
from tauten.model.load import make_robot
from tauten.model.numerics import Array
from tauten.model.schema import Changes

EXACTLY = 1e-9  # m, half the side of a box around one node
SPACING = 0.05  # m, of the points of a tendon
STIFFNESS = 50e9 * np.pi * 0.75e-3**4 / 4.0  # N m², against bending
TENDON_ARM = """
name = "arm"
gravity = [0.0, 0.0, 0.0]

[material]
young_modulus = 50e9
poisson_ratio = 0.3
density = 6450.0

[[profiles]]
kind = "tube"
name = "rod"
outer = 1.5e-3

[[bodies]]
name = "rod"
beam = { points = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.4]], elements = 8, profile = "rod" }
fixed = [{ kind = "sphere", centre = [0.0, 0.0, 0.0], radius = 1e-6 }]

[[effectors]]
name = "tip"
point = [0.0, 0.0, 0.4]
"""
DISC = """
[[bodies]]
name = "disc"
mesh = { file = "disc.vtu" }
position = [-0.0025, -0.0025, 0.4]
rigid = true

[[attachments]]
kind = "glue"
region = { kind = "sphere", centre = [0.0, 0.0, 0.4], radius = 1e-6, body = "rod" }
to = { kind = "all", body = "disc" }
"""
TENDON = """
[[cables]]
name = "tendon{number}"
points = {points}
max_outside = 0.013
max_tension = {tension}
max_pull = 0.02
min_pull = -0.02
max_rate = 0.05
"""


def rectangle(name: str, width: float, height: float) -> dict[str, Any]:
    """A rectangular profile of the robot file: width along axis 2, height along axis 3 [m]."""
    return {"kind": "bar", "name": name, "width": width, "height": height}


def path_of_beams(nodes: Array, up: tuple[float, float, float], profile: str) -> list[Any]:
    """Beams from node to node, all of one profile."""
    count = len(nodes) - 1
    return [{"ends": [i, i + 1], "profile": profile, "up": up} for i in range(count)]


def build(
    folder: Path,
    nodes: Array,
    beams: list[Any],
    profiles: list[dict[str, Any]],
    material: tuple[float, float, float],
    held: list[int],
    loaded: int,
    **changes: Any,
) -> Robot[BeamBody]:
    """A robot without gravity that holds some nodes and has an effector on another one.

    Its only cable runs from the first held node to the loaded one, unless `cables` is given.

    Args:
        folder: where the file of beams is written.
        nodes: (n_nodes, 3) positions at rest [m].
        beams: of that file.
        profiles: of the robot file.
        material: Young's modulus [Pa], Poisson's ratio, density [kg/m³].
        held: nodes that neither move nor turn.
        loaded: node that carries the effector.
        changes: other fields of the robot file, and the surfaces of the file of beams.
    """
    surfaces = changes.pop("surfaces", [])
    network = {"nodes": nodes.tolist(), "beams": beams, "surfaces": surfaces}
    (folder / "beams.json").write_text(json.dumps(network))
    E, nu, density = material
    tip = nodes[loaded].tolist()
    contents: dict[str, Any] = {
        "name": "benchmark",
        "bodies": [{"name": "frame", "beam": {"file": "beams.json"}}],
        "profiles": profiles,
        "material": {"young_modulus": E, "poisson_ratio": nu, "density": density},
        "gravity": [0.0, 0.0, 0.0],
        "fixed": [
            {"lower": (nodes[i] - EXACTLY).tolist(), "upper": (nodes[i] + EXACTLY).tolist()}
            for i in held
        ],
        "cables": [cable([nodes[held[0]].tolist(), tip])],
        "effectors": [{"name": "tip", "point": tip}],
        "regions": [
            {"name": item["name"], "kind": "group", "group": item["name"]} for item in surfaces
        ],
    }
    robot = make_robot(contents | changes, folder / "robot.toml", Changes())
    assert isinstance(robot.body, BeamBody)
    return robot


def cable(points: list[list[float]]) -> dict[str, Any]:
    """A cable through points [m] that nothing limits."""
    limits = {"max_tension": 1e6, "max_pull": 1e3, "max_rate": 1e3}
    return {"name": "cable", "points": points, **limits}


def with_profile(robot: Robot[BeamBody], profile: Profile, material: Material) -> Robot[BeamBody]:
    """The robot with one cross-section for all its beams, for constants that no shape of a file has."""
    D = np.array(
        [natural_stiffness(profile, material, length) for length in robot.body.beams.length]
    )
    body = robot.body
    return replace(robot, body=replace(body, beams=replace(body.beams, D=D)))


def under_force(
    robot: Robot[BeamBody], forces: list[Array], tolerance: float, most: int = 200
) -> tuple[Simulator, list[Array]]:
    """Settle under forces (3,) on the effector one after the other.

    Returns:
        The simulator, and the effector's position (3,) [m] at every force.
    """
    simulator, positions = Simulator(robot, contact="none"), []
    for force in forces:
        simulator.load(np.zeros(3), force)
        report = simulator.settle(
            effort=np.zeros(robot.n_a), tolerance=tolerance, max_iterations=most
        )
        assert report.converged, (
            f"no equilibrium under {force.tolist()} N, moved {report.movement:.1e} m"
        )
        positions.append(simulator.effector[0])
    return simulator, positions


def tendon_arm(folder: Path, tension: float, disc: bool = False) -> Path:
    """The robot file of an arm of 0.4 m, whose tendons bear a largest tension [N].

    Args:
        folder: where it is written.
        tension: largest one of each tendon [N].
        disc: whether a plate of 0.1 g is glued to the tip, a rigid body.
    """
    text = TENDON_ARM
    if disc:
        mesh = box_mesh((5e-3, 5e-3, 1e-3), (1, 1, 1))
        meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]).write(folder / "disc.vtu")
        text += DISC
    for number in range(3):
        x, y = (float(0.012 * f(2.0 * np.pi * number / 3.0)) for f in (np.cos, np.sin))
        points = [[x, y, SPACING * i] for i in range(9)]
        text += TENDON.format(number=number, points=points, tension=tension)
    path = folder / "arm.toml"
    path.write_text(text, encoding="utf-8")
    return path
