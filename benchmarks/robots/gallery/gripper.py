"""The gripper: one finger's mesh three times round a palm, a cable in each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.robots.gallery.blocks import grid_cells, write_mesh
from benchmarks.robots.gallery.text import FOLLOWING, RATE, REDUCED_TABLES, point_list
from tauten.model.numerics import Array, Ints

HEAD = """\
# Three fingers of cast silicone that hang round a palm; a cable bends each inward.
# Made by python -m benchmarks.robots.gallery, as is gripper_finger.vtu.
name = "gripper"
frame = "palm"               # origin in the middle of the palm, z up
gravity = [0.0, 0.0, -9.81]

[material]
silicone = "dragon-skin-30"
"""

FINGER = """
[[bodies]]
name = "{name}"
mesh = {{ file = "gripper_finger.vtu", element = "smoothed" }}
rotation = {{ axis = [0.0, 0.0, 1.0], angle_deg = {angle:.1f} }}
position = [{x:.6f}, {y:.6f}, 0.0]
fixed = [{{ lower = [-1.0, -1.0, 0.0], upper = [1.0, 1.0, 0.0] }}]

[[cables]]
name = "{name}"
pull_point = [{px:.5f}, {py:.5f}, 0.005]
points = [
{points}
]
max_tension = 8.0
max_pull = 0.014
max_rate = 0.05

[[effectors]]
name = "tip{number}"
point = [{tx:.5f}, {ty:.5f}, {tz:g}]
"""


@dataclass(frozen=True, slots=True)
class GripperShape:
    """Dimensions [m] and grid of the gripper; a finger's x points away from the palm's axis.

    Attributes:
        radius: of the fingers' axes.
        length: of a finger, along −z.
        root: size of a finger's section at the palm, in x and y.
        tip: the same at its tip.
        cable: distance of the cable from the inner side.
        across: cells over a side of the section.
        along: cells over the length.
    """

    radius: float = 0.030
    length: float = 0.070
    root: tuple[float, float] = (0.012, 0.014)
    tip: tuple[float, float] = (0.007, 0.009)
    cable: float = 0.0015
    across: int = 2
    along: int = 14

    def size(self, depth: Array) -> Array:
        """Size of the section at depths (d,) below the palm: (2, d) [m]."""
        share = depth / self.length
        sizes: Array = np.outer(self.root, 1.0 - share) + np.outer(self.tip, share)
        return sizes


def make_cells(shape: GripperShape) -> tuple[Array, Ints]:
    """Nodes (n, 3) and hexahedra (c, 8) of a finger."""
    u = np.linspace(-0.5, 0.5, shape.across + 1)
    depth = np.linspace(0.0, shape.length, shape.along + 1)
    x, y, z = np.meshgrid(u, u, -depth, indexing="ij")
    width, height = shape.size(depth)
    return grid_cells(np.stack([x * width, y * height, z], axis=-1))


def make_text(shape: GripperShape) -> str:
    """The robot file."""
    text = HEAD + REDUCED_TABLES.replace(RATE, RATE + FOLLOWING)
    depth = np.linspace(0.0, shape.length, 8)
    depth[0], depth[-1] = 0.002, depth[-1] - 0.004
    r = shape.radius - 0.5 * shape.size(depth)[0] + shape.cable
    for k in range(3):
        angle = np.radians(120.0 * k)
        c, s = np.cos(angle), np.sin(angle)
        places = np.stack([r * c, r * s, -depth], axis=1)
        text += FINGER.format(
            name=f"finger{k}", number=k, angle=120.0 * k, x=shape.radius * c, y=shape.radius * s,
            px=places[0, 0], py=places[0, 1], points=point_list(places),
            tx=shape.radius * c, ty=shape.radius * s, tz=-shape.length,
        )  # fmt: skip
    return text


def make_gripper(folder: Path) -> list[str]:
    """Write robot file and mesh into a folder; returns lines about them."""
    shape = GripperShape()
    (folder / "gripper.toml").write_text(make_text(shape), encoding="utf-8")
    return [write_mesh(folder / "gripper_finger.vtu", *make_cells(shape))]
