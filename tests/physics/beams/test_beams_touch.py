"""Bodies that are beams in contact with obstacles and with other bodies, against beam theory and statics."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.joined import PLASTIC, joined, push, rod

from tauten.model import Robot, Simulator

G, L, DIAMETER = 9.81, 0.1, 2e-3
ROOT = {"body": "rod", "kind": "sphere", "centre": [0.0, 0.0, 0.0], "radius": 1e-6}
LINE = [[0.0, 0.0, 0.0], [L, 0.0, 0.0]]
WEIGHT = PLASTIC["density"] * np.pi / 4.0 * DIAMETER**2 * G  # N/m


def bearing(robot: Robot, effort: list[float]) -> float:
    """Sum of the upward contact forces in equilibrium [N]."""
    simulator = Simulator(robot)
    assert simulator.settle(effort=effort).converged
    return float(np.abs(simulator.contact_forces[:, 2]).sum())


def test_a_propped_cantilever_rests_with_three_eighths_of_its_weight() -> None:
    """Under its weight w L, clamped and propped at its end, a beam presses 3 w L / 8 on the prop."""
    radius = 5e-3
    prop = {
        "name": "prop", "shape": "sphere",
        "parameters": {"centre": [L, 0.0, -radius - 0.5 * DIAMETER], "radius": radius},
    }  # fmt: skip
    robot = joined(
        [rod("rod", LINE, fixed=[ROOT])],
        gravity=[0.0, 0.0, -G],
        obstacles=[prop],
        contacts=[{"against": "prop", "points": "vertices"}],
    )
    assert bearing(robot, [0.0]) == pytest.approx(3.0 / 8.0 * WEIGHT * L, rel=0.02)


def test_a_rod_bears_on_a_block_what_it_is_loaded_with() -> None:
    size, force = (0.02, 0.01, 0.01), 0.02
    block = {
        "name": "block", "position": [L - 0.5 * size[0], -0.005, -0.5 * DIAMETER - size[2] - 1e-4],
        "material": {**PLASTIC, "young_modulus": 1e7},
        "fixed": [{"body": "block", "lower": [-1.0, -1.0, -1e-6], "upper": [1.0, 1.0, 1e-6]}],
    }  # fmt: skip
    robot = joined(
        [rod("rod", LINE, fixed=[ROOT]), block],
        {"block": (size, (4, 2, 2))},
        regions=[{"name": name, "kind": "all", "body": name} for name in ("rod", "block")],
        contacts=[{"candidates": "rod", "against": "block", "points": "vertices"}],
        forces=[push("push", LINE[1], [0.0, 0.0, -1.0])],
    )
    bending = 3.0 * 2e9 * np.pi / 64.0 * DIAMETER**4 / L**3 * 1e-4  # N, to close the gap
    assert bearing(robot, [force]) == pytest.approx(force - bending, rel=0.03)


def test_the_surface_of_a_bent_rod_is_closed_around_its_material() -> None:
    """Every edge has one triangle on each side; the volume is that of a prism but for the kink."""
    bent = [[0.0, 0.0, 0.0], [0.05, 0.0, 0.0], [0.05, 0.05, 0.0]]
    robot = joined(
        [rod("rod", bent, fixed=[ROOT])],
        obstacles=[{"name": "floor", "shape": "plane", "parameters": {
            "point": [0.0, 0.0, -0.01], "normal": [0.0, 0.0, 1.0],
        }}],
        contacts=[{"against": "floor", "points": 3}, {"against": "itself", "points": 3}],
    )  # fmt: skip
    triangles = robot.contacts.pairs[1].triangles
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert {(a, b) for a, b in edges.tolist()} == {(b, a) for a, b in edges.tolist()}
    a, b, c = np.moveaxis(robot.body.mesh.nodes[triangles], 1, 0)
    volume = float(np.einsum("ti,ti->", a, np.cross(b, c))) / 6.0
    prism = 4.0 * np.sin(np.pi / 4.0) * (0.5 * DIAMETER) ** 2 * L
    assert volume == pytest.approx(prism, rel=0.05)
