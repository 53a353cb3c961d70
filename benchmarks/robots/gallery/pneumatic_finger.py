"""The pneumatic finger: bellows of cast silicone on a stiff layer, one chamber through all of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.robots.gallery.blocks import grid_cells, used_cells, write_mesh
from tauten.model.numerics import Array, Bools, Ints

HEAD = """\
# Bellows of cast silicone on a stiff layer; air bends the finger towards the layer, and folds close.
# Made by python -m benchmarks.robots.gallery, as is pneumatic_finger.vtu.
name = "pneumatic_finger"
frame = "finger_base"        # origin on the lower edge of the fixed face, x along the finger, z up
gravity = [0.0, 0.0, -9.81]

[mesh]
file = "pneumatic_finger.vtu"
element = "smoothed"

[material]
silicone = "dragon-skin-30"

[[materials]]                # the stiff layer: fabric in silicone
region = {{ lower = [-1.0, -1.0, -1.0], upper = [1.0, 1.0, {stiff:g}] }}
law = "neo-hookean"
young_modulus = 5.0e6
poisson_ratio = 0.45
density = 1200.0

[[fixed]]
lower = [0.0, -1.0, -1.0]
upper = [0.0, 1.0, 1.0]

[[chambers]]
name = "air"
inside = [{inside}]
min_pressure = {vacuum:g}         # vacuum closes the folds
max_pressure = {pressure:g}
max_volume_change = {volume:g}
max_rate = {rate:g}

[[regions]]                  # the walls of the folds between the bellows
name = "folds"
kind = "union"
of = [
{folds}
]

[[contacts]]
candidates = "folds"
against = "itself"

[[effectors]]
name = "tip"
point = [{tip}]

[integration]
rayleigh_stiffness = 0.02

[controller]
rate = 50.0
basis = "pneumatic_finger"
horizon = 0.04     # s; the tip follows its volume slowly: a longer one leads targets less evenly

[model]
order = "reduced"

[service]
target_timeout = 0.5
release_time = 1.0
"""


@dataclass(frozen=True, slots=True)
class BellowsShape:
    """Dimensions [m] and grid of the finger.

    Attributes:
        bellows: number of bellows.
        cap: length of the closed ends.
        wall: thickness of the walls across the finger.
        room: length of a bellow's inside, two cells.
        gap: length of a fold.
        y: grid lines over the width; the first and the last cell are walls.
        z: grid lines over the height: stiff layer, its cover, channel, cover of the channel, inside, roof.
    """

    bellows: int = 6
    cap: float = 0.004
    wall: float = 0.0012
    room: float = 0.0064
    gap: float = 0.0008
    y: tuple[float, ...] = (-0.009, -0.0072, -0.0024, 0.0024, 0.0072, 0.009)
    z: tuple[float, ...] = (0.0, 0.0015, 0.003, 0.0055, 0.0072, 0.0102, 0.0132, 0.0152)

    @property
    def lines(self) -> list[tuple[float, str]]:
        """Length and kind of each cell along the finger."""
        room = [(0.5 * self.room, "room")] * 2
        one = [(self.wall, "wall"), *room, (self.wall, "wall")]
        cells = [(self.cap, "cap")]
        for number in range(self.bellows):
            cells += [(self.gap, "fold")] * (number > 0) + one
        return [*cells, (self.cap, "cap")]


def is_solid(shape: BellowsShape) -> Bools:
    """Which cells of the grid are material: (x, y, z) bool."""
    kinds = [kind for _, kind in shape.lines]
    n_y, n_z = len(shape.y) - 1, len(shape.z) - 1
    solid = np.ones((len(kinds), n_y, n_z), dtype=bool)
    for i, kind in enumerate(kinds):
        if kind != "cap":
            solid[i, 1:-1, 2] = False  # the channel
        if kind == "room":
            solid[i, 1:-1, 3:-1] = False
        if kind == "fold":
            solid[i, :, 4:] = False
    return solid


def make_cells(shape: BellowsShape) -> tuple[Array, Ints]:
    """Nodes (n, 3) and hexahedra (c, 8) of the finger."""
    x = np.concatenate([[0.0], np.cumsum([length for length, _ in shape.lines])])
    grid = np.stack(np.meshgrid(x, shape.y, shape.z, indexing="ij"), axis=-1)
    nodes, cells = grid_cells(grid)
    return used_cells(nodes, cells[is_solid(shape).ravel()])


def make_text(shape: BellowsShape) -> str:
    """The robot file."""
    ends = np.concatenate([[0.0], np.cumsum([length for length, _ in shape.lines])])
    folds = []
    for i, (_, kind) in enumerate(shape.lines):
        if kind == "fold":
            low, high = ends[i] - 1e-4, ends[i + 1] + 1e-4
            folds.append(
                f'  {{ kind = "box", lower = [{low:.5f}, -1.0, {shape.z[4] - 1e-4:.5f}], '
                f"upper = [{high:.5f}, 1.0, 1.0] }},"
            )
    first = shape.cap + shape.wall + 0.5 * shape.room
    return HEAD.format(
        vacuum=-12e3, pressure=25e3, volume=6e-6, rate=2.5e-6,
        stiff=shape.z[1], folds="\n".join(folds),
        inside=f"{first:g}, 0.0, {0.5 * (shape.z[4] + shape.z[5]):g}",
        tip=f"{ends[-1]:.5f}, 0.0, {shape.z[2]:g}",
    )  # fmt: skip


def make_pneumatic_finger(folder: Path) -> list[str]:
    """Write robot file and mesh into a folder; returns lines about them."""
    shape = BellowsShape()
    name = "pneumatic_finger"
    (folder / f"{name}.toml").write_text(make_text(shape), encoding="utf-8")
    return [write_mesh(folder / f"{name}.vtu", *make_cells(shape))]
