"""The ring of SoftRobots that rolls on a floor, pulled by four cables between points of its own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import meshio
import numpy as np
import pytest

from support.sofa.elements import points_as_in_sofa
from tauten.model import Robot, load_robot
from tauten.model.load import contacts
from tauten.model.numerics import Array, Ints

MM = 1e-3
_NEAR = 25  # triangles that are looked at

RING = """
name = "ring"
gravity = [0.0, -9.18, 0.0]
[[bodies]]
name = "ring"
mesh = { file = "ring.vtu" }
free = true
material = { young_modulus = 5e5, poisson_ratio = 0.3, total_mass = 0.042, mass = "nodes" }
[[effectors]]
name = "middle"
kind = "centre"
region = { lower = [-1.0, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }
[[obstacles]]
name = "floor"
shape = "plane"
parameters = { point = [0.0, -0.021, 0.0], normal = [0.0, 1.0, 0.0] }
[[contacts]]
against = "floor"
points = "vertices"
friction = 0.8
[contact]
distance = 1e-3
alarm_distance = 5e-3
[integration]
scheme = "implicit-euler"
rayleigh_mass = 0.015
rayleigh_stiffness = 0.015
[controller]
rate = 100.0
"""
CABLE = """
[[cables]]
name = "cable{number}"
points = {points}
max_tension = 10.0
max_pull = 0.02
max_rate = 1.0
"""


def ring(data: Path, folder: Path) -> Robot:
    """The ring, with SOFA's contact points on its surface instead of the vertices of its mesh.

    Args:
        data: of SOFA's robots.
        folder: into which files go.
    """
    model = np.load(data / "circular_model.npz")
    meshio.Mesh(MM * model["nodes"], [("tetra", model["tets"])]).write(folder / "ring.vtu")
    ends = (MM * model["cable_pts"]).reshape(4, 2, 3).tolist()
    text = RING + "".join(CABLE.format(number=i, points=one) for i, one in enumerate(ends))
    (folder / "ring.toml").write_text(text)
    with points_as_in_sofa(model, "cable"), pytest.MonkeyPatch.context() as patch:
        patch.setattr(contacts, "candidates_on", _nearest_to(MM * model["col_pts"]))
        return load_robot(folder / "ring.toml")


def command(row: Mapping[str, float]) -> Array:
    """How far SOFA has its cables shortened in a step: (4,) [m]."""
    names = ("cmd1_or_targetshift", "cmd2", "cmd3", "cmd4")
    found: Array = MM * np.array([row[name] for name in names])
    return found


def _nearest_to(points: Array):  # type: ignore[no-untyped-def]
    """As `candidates_on`: candidates where the surface is nearest to these points."""

    def candidates_on(vertices: Array, triangles: Ints, *_: object) -> tuple[Ints, Array]:
        centres = vertices[triangles].mean(axis=1)
        nodes, weights = [], []
        for point in points:
            near = np.argsort(np.linalg.norm(centres - point, axis=1))[:_NEAR]
            found = [_weights(point, vertices[triangles[one]]) for one in near]
            apart = [
                np.linalg.norm(w @ vertices[triangles[one]] - point)
                for w, one in zip(found, near, strict=True)
            ]
            best = int(np.argmin(apart))
            nodes.append(triangles[near[best]])
            weights.append(found[best])
        return np.array(nodes), np.array(weights)

    return candidates_on


def _weights(point: Array, corners: Array) -> Array:
    """Barycentric weights (3,) of a point of a triangle that is near a point, none negative."""
    edges = (corners[1:] - corners[0]).T
    along = np.linalg.lstsq(edges, point - corners[0], rcond=None)[0]
    found = np.maximum([1.0 - along.sum(), *along], 0.0)
    return found / found.sum()
