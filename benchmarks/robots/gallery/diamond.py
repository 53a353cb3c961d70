"""The diamond: four bent legs of cast silicone under a common block, each with a cable at its knee."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.robots.gallery.blocks import grid_cells, joined, write_mesh
from benchmarks.robots.gallery.text import REDUCED_TABLES
from tauten.model.numerics import Array, Ints

HEAD = """\
# Four bent legs of cast silicone that carry a block; a cable pulls the knee of each towards the base.
# Made by python -m benchmarks.robots.gallery, as is diamond.vtu.
name = "diamond"
frame = "diamond_base"       # origin in the middle of the base, z up
gravity = [0.0, 0.0, -9.81]

[mesh]
file = "diamond.vtu"
element = "smoothed"

[material]
silicone = "dragon-skin-30"

[[fixed]]
lower = [-1.0, -1.0, 0.0]
upper = [1.0, 1.0, 0.0]

[[effectors]]
name = "top"
point = [0.0, 0.0, {top:g}]
"""

CABLE = """
[[cables]]                   # from the base to the knee
name = "{name}"
pull_point = [{px:g}, {py:g}, 0.0]
points = [[{x:g}, {y:g}, {z:g}]]
max_tension = 8.0
min_pull = {out:g}             # the winch pays out when the other legs move this one
max_pull = {pull:g}
max_rate = 0.06
"""

NAMES = ("east", "north", "west", "south")


@dataclass(frozen=True, slots=True)
class DiamondShape:
    """Dimensions [m] and grid of the diamond; r is the distance from its axis.

    Attributes:
        inner: (r, z) of the inner side of a leg at foot, knee and block.
        outer: (r, z) of its outer side there.
        width: of legs and block.
        pull_radius: r of the hole in the base that a cable comes from.
        along: cells between foot and knee, and between knee and block.
        across: cells over the width, and over the thickness.
    """

    inner: tuple[tuple[float, float], ...] = ((0.020, 0.0), (0.036, 0.030), (0.008, 0.056))
    outer: tuple[tuple[float, float], ...] = ((0.030, 0.0), (0.047, 0.032), (0.008, 0.068))
    width: float = 0.016
    pull_radius: float = 0.008
    along: int = 6
    across: int = 2


def turn(quarter: int) -> Array:
    """Rotation (3, 3) by quarters of a turn about z, exact."""
    c, s = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[quarter % 4]
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def make_cells(shape: DiamondShape) -> tuple[Array, Ints]:
    """Nodes (n, 3) and hexahedra (c, 8) of the diamond."""
    knots = np.arange(3) * shape.along
    steps = np.arange(2 * shape.along + 1)
    sides = np.array(
        [[np.interp(steps, knots, [place[i] for place in side]) for i in range(2)]
         for side in (shape.inner, shape.outer)]
    )  # fmt: skip
    share = np.linspace(0.0, 1.0, shape.across + 1)
    # (2, a + 1, steps): r and z over the thickness
    middle = np.einsum("sik,st->itk", sides, np.stack([1.0 - share, share]))
    y = shape.width * (share - 0.5)
    r, z = (np.broadcast_to(value[:, None], (len(share), len(y), len(steps))) for value in middle)
    leg = np.stack([r, np.broadcast_to(y[:, None], r.shape), z], axis=-1)  # (a, a, s, 3)
    bottom, top = shape.inner[-1][1], shape.outer[-1][1]
    grid = np.meshgrid(y, y, bottom + share * (top - bottom), indexing="ij")
    block = grid_cells(np.stack(grid, axis=-1))
    legs = [grid_cells(leg @ turn(k).T) for k in range(4)]
    return joined([*legs, block])


def make_text(shape: DiamondShape) -> str:
    """The robot file."""
    text = (HEAD + REDUCED_TABLES).format(top=shape.outer[-1][1])
    r, z = (0.5 * (a + b) for a, b in zip(shape.inner[1], shape.outer[1], strict=True))
    for k, name in enumerate(NAMES):
        x, y = (turn(k) @ [r, 0.0, 0.0])[:2] + 0.0
        px, py = (turn(k) @ [shape.pull_radius, 0.0, 0.0])[:2] + 0.0
        text += CABLE.format(name=name, px=px, py=py, x=x, y=y, z=z, out=-0.012, pull=0.012)
    return text


def make_diamond(folder: Path) -> list[str]:
    """Write robot file and mesh into a folder; returns lines about them."""
    shape = DiamondShape()
    (folder / "diamond.toml").write_text(make_text(shape), encoding="utf-8")
    return [write_mesh(folder / "diamond.vtu", *make_cells(shape))]
