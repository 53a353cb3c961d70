"""The accordion: closed round bellows of cast silicone with one chamber, and three cables along them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.robots.gallery.blocks import disc, grid_cells, joined, write_mesh
from benchmarks.robots.gallery.text import REDUCED_TABLES, point_list
from tauten.model.numerics import Array, Ints

HEAD = """\
# Round bellows of cast silicone that stand on their closed lower end: air lengthens, cables bend them.
# Made by python -m benchmarks.robots.gallery, as is accordion.vtu.
name = "accordion"
frame = "accordion_base"     # origin in the middle of the lower end, z up
gravity = [0.0, 0.0, -9.81]

[mesh]
file = "accordion.vtu"
element = "smoothed"

[material]
silicone = "dragon-skin-30"

[[fixed]]
lower = [-1.0, -1.0, 0.0]
upper = [1.0, 1.0, 0.0]

[[chambers]]
name = "air"
inside = [0.0, 0.0, {middle:g}]
max_pressure = {pressure:.1f}
max_volume_change = {volume:g}
max_rate = {rate:g}

[[effectors]]
name = "top"
point = [0.0, 0.0, {top:g}]
"""

CABLE = """
[[cables]]                   # through the crests
name = "{name}"
pull_point = [{x:.5f}, {y:.5f}, -0.002]
points = [
{points}
]
max_tension = 6.0
min_pull = {out:g}
max_pull = {pull:g}
max_rate = 0.03
"""


@dataclass(frozen=True, slots=True)
class AccordionShape:
    """Dimensions [m] and grid of the accordion.

    Attributes:
        folds: number of crests.
        pitch: height of a fold.
        plate: thickness of the closed ends.
        valley: inner radius of the wall between crests.
        crest: inner radius of the wall at a crest.
        wall: thickness of the wall, across the axis.
        sides: cells round the wall, a multiple of 4.
        levels: cells over the height of half a fold.
    """

    folds: int = 4
    pitch: float = 0.010
    plate: float = 0.003
    valley: float = 0.010
    crest: float = 0.0145
    wall: float = 0.0024
    sides: int = 12
    levels: int = 2

    @property
    def height(self) -> float:
        """From the lower to the upper end [m]."""
        return self.folds * self.pitch + 2.0 * self.plate

    @property
    def crests(self) -> Array:
        """Heights of the crests [m]."""
        first = self.plate + 0.5 * self.pitch
        return np.linspace(first, first + (self.folds - 1) * self.pitch, self.folds)


def make_cells(shape: AccordionShape) -> tuple[Array, Ints]:
    """Nodes (n, 3) and hexahedra (c, 8) of the accordion."""
    core = disc(shape.sides // 4)  # (m, m, 2)
    ends = np.array([0.0, 0.5, 1.0]) * shape.plate
    half = np.linspace(0.0, shape.folds * shape.pitch, 2 * shape.folds * shape.levels + 1)
    z = np.concatenate([ends[:-1], shape.plate + half, shape.height - ends[-2::-1]])
    phase = np.clip((z - shape.plate) / shape.pitch, 0.0, shape.folds) % 1.0
    inner = shape.valley + (shape.crest - shape.valley) * (1.0 - np.abs(2.0 * phase - 1.0))
    rim = np.concatenate([core[:-1, 0], core[-1, :-1], core[:0:-1, -1], core[0, ::-1]])  # closed
    radius = inner[None, :] + np.array([0.0, shape.wall])[:, None]  # (2, l)
    ring = rim[:, None, None] * radius[..., None]  # (sides + 1, 2, l, 2)
    parts = [grid_cells(_at_heights(ring, z))]
    for level in (z[:3], z[-3:]):
        flat = shape.valley * core[:, :, None].repeat(3, axis=2)
        parts.append(grid_cells(_at_heights(flat, level)))
    return joined(parts)


def _at_heights(flat: Array, z: Array) -> Array:
    """A grid of nodes (a, b, c, 3) of one with x and y (a, b, c, 2) and heights z (c,)."""
    height = np.broadcast_to(z, flat.shape[:3])
    nodes: Array = np.concatenate([flat, height[..., None]], axis=-1)
    return nodes


def make_text(shape: AccordionShape) -> str:
    """The robot file."""
    text = (HEAD + REDUCED_TABLES).format(
        middle=0.5 * shape.height, top=shape.height, pressure=25e3, volume=1.5e-5, rate=2e-5
    )
    r = shape.crest + 0.5 * shape.wall
    for k in range(3):
        angle = np.radians(45.0 + 120.0 * k)
        x, y = r * np.cos(angle), r * np.sin(angle)
        places = np.array([[x, y, z] for z in shape.crests])
        text += CABLE.format(
            name=f"cable{k}", x=x, y=y, points=point_list(places), out=-0.012, pull=0.012
        )
    return text


def make_accordion(folder: Path) -> list[str]:
    """Write robot file and mesh into a folder; returns lines about them."""
    shape = AccordionShape()
    (folder / "accordion.toml").write_text(make_text(shape), encoding="utf-8")
    return [write_mesh(folder / "accordion.vtu", *make_cells(shape))]
