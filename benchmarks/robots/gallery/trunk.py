"""The trunk: a tapered cylinder of cast silicone that hangs, with eight cables in two sections."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.robots.gallery.blocks import disc, grid_cells, write_mesh
from benchmarks.robots.gallery.text import FOLLOWING, RATE, REDUCED_TABLES, point_list
from tauten.model.numerics import Array, Ints

SUBSTEPS = (
    "substeps = 2                # it swings freely between cables that become slack and taut\n"
)
HEAD = """\
# A trunk of cast silicone that hangs from its base: four cables to the tip, four to the middle.
# Made by python -m benchmarks.robots.gallery, as is trunk.vtu.
name = "trunk"
frame = "trunk_base"         # origin in the middle of the fixed face, z up
gravity = [0.0, 0.0, -9.81]

[mesh]
file = "trunk.vtu"
element = "smoothed"

[material]
silicone = "dragon-skin-30"

[[fixed]]
lower = [-1.0, -1.0, 0.0]
upper = [1.0, 1.0, 0.0]

[[effectors]]
name = "tip"
point = [0.0, 0.0, {tip:g}]
"""

CABLE = """
[[cables]]
name = "{name}"
pull_point = [{x:.5f}, {y:.5f}, 0.005]
points = [
{points}
]
max_tension = 15.0
min_pull = {out:g}            # winches pay out, for what is on the outer side of a bend
max_pull = {pull:g}
max_rate = 0.06
"""


@dataclass(frozen=True, slots=True)
class TrunkShape:
    """Dimensions [m] and grid of the trunk.

    Attributes:
        length: along −z.
        base: radius at the base.
        tip: radius at the tip.
        inset: of the cables from the surface.
        across: cells over the diameter.
        along: cells over the length, even.
    """

    length: float = 0.160
    base: float = 0.018
    tip: float = 0.010
    inset: float = 0.004
    across: int = 3
    along: int = 16

    def radius(self, depth: Array) -> Array:
        """Radius at a depth below the base [m]."""
        return self.base + (self.tip - self.base) * depth / self.length


def make_cells(shape: TrunkShape) -> tuple[Array, Ints]:
    """Nodes (n, 3) and hexahedra (c, 8) of the trunk."""
    depth = np.linspace(0.0, shape.length, shape.along + 1)
    flat = disc(shape.across)[:, :, None] * shape.radius(depth)[:, None]  # (a, a, l, 2)
    z = np.broadcast_to(-depth, flat.shape[:3])
    return grid_cells(np.concatenate([flat, z[..., None]], axis=-1))


def make_text(shape: TrunkShape) -> str:
    """The robot file."""
    tables = REDUCED_TABLES.replace(RATE, RATE + SUBSTEPS + FOLLOWING)
    text = (HEAD + tables).format(tip=-shape.length)
    for kind, angle0, share, pull in (("long", 0.0, 1.0, 0.050), ("short", 45.0, 0.5, 0.025)):
        depth = np.linspace(0.0, share * shape.length, round(share * 16) + 1)
        depth[0], depth[-1] = 0.002, depth[-1] - 0.002
        for k in range(4):
            angle = np.radians(angle0 + 90.0 * k)
            r = shape.radius(depth) - shape.inset
            places = np.stack([r * np.cos(angle), r * np.sin(angle), -depth], axis=1)
            x, y = places[0, :2]
            made = {"name": f"{kind}{k}", "x": x, "y": y, "points": point_list(places)}
            text += CABLE.format(**made, out=-pull, pull=pull)
    return text


def make_trunk(folder: Path) -> list[str]:
    """Write robot file and mesh into a folder; returns lines about them."""
    shape = TrunkShape()
    (folder / "trunk.toml").write_text(make_text(shape), encoding="utf-8")
    return [write_mesh(folder / "trunk.vtu", *make_cells(shape))]
