"""The tripod: a plate of cast silicone on three arms, each turned by a servo at its end."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.robots.gallery.blocks import grid_cells, joined, write_mesh
from tauten.model.numerics import Array, Ints

HEAD = """\
# A plate of cast silicone on three arms; a servo turns the end of each about an axis across the arm.
# Made by python -m benchmarks.robots.gallery, as is tripod.vtu.
name = "tripod"
frame = "tripod_base"        # origin in the middle of the plate's lower face, z up
gravity = [0.0, 0.0, -9.81]

[mesh]
file = "tripod.vtu"
element = "smoothed"

[material]
silicone = "dragon-skin-30"

[[effectors]]                # height and tilt; sideways the plate goes where these lead it
name = "plate"
kind = "frame"
region = {{ kind = "cylinder", start = [0.0, 0.0, -0.001], end = [0.0, 0.0, {above:g}], radius = {radius:g} }}
weight = [0.0, 0.0, 1.0, 1.0, 1.0, 0.0]

[integration]
rayleigh_stiffness = 0.02

[controller]
rate = 50.0

[model]
order = "reduced"

[service]
target_timeout = 0.5
release_time = 1.0
"""

DRIVE = """
[[drives]]
name = "{name}"
region = {{ kind = "half_space", point = [{x:.6f}, {y:.6f}, 0.0], normal = [{nx:.6f}, {ny:.6f}, 0.0] }}
axis = [{tx:.6f}, {ty:.6f}, 0.0]
through = [{px:.6f}, {py:.6f}, 0.0]
max_angle = 0.5
max_torque = 0.5
max_rate = 2.0
"""


@dataclass(frozen=True, slots=True)
class TripodShape:
    """Dimensions [m] and grid of the tripod.

    Attributes:
        side: of the hexagonal plate, and width of an arm.
        arm: length of an arm.
        thickness: of plate and arms.
        horn: length of the end of an arm that a servo turns.
        axis: distance of the servo's axis from the end of the arm.
        across: cells over a side.
        along: cells over the length of an arm.
        through: cells over the thickness.
    """

    side: float = 0.016
    arm: float = 0.040
    thickness: float = 0.006
    horn: float = 0.008
    axis: float = 0.010
    across: int = 2
    along: int = 10
    through: int = 2

    @property
    def flat(self) -> float:
        """Distance of a side of the plate from its middle [m]."""
        return self.side * float(np.sqrt(0.75))


def make_cells(shape: TripodShape) -> tuple[Array, Ints]:
    """Nodes (n, 3) and hexahedra (c, 8) of the tripod."""
    corners = [
        shape.side * np.array([np.cos(angle), np.sin(angle)])
        for angle in np.radians(60.0 * np.arange(6) - 30.0)
    ]
    u = np.linspace(0.0, 1.0, shape.across + 1)
    z = np.linspace(0.0, shape.thickness, shape.through + 1)
    parts = []
    for k in range(3):
        # a rhombus of the hexagon, from its centre
        a, c = corners[2 * k], corners[(2 * k + 2) % 6]
        parts.append(grid_cells(raised(u[:, None, None] * a + u[None, :, None] * c, z)))
        out = 0.5 * (corners[2 * k] + corners[2 * k + 1]) / shape.flat  # unit vector along an arm
        side = corners[2 * k] + u[:, None] * (corners[2 * k + 1] - corners[2 * k])  # (m, 2)
        way = np.linspace(0.0, shape.arm, shape.along + 1)
        parts.append(grid_cells(raised(side[:, None] + way[None, :, None] * out, z)))
    return joined(parts)


def raised(flat: Array, z: Array) -> Array:
    """A grid of nodes (a, b, c, 3) over one in the plane (a, b, 2), at heights z (c,)."""
    shape = (*flat.shape[:2], len(z))
    grid = np.broadcast_to(flat[:, :, None], (*shape, 2))
    return np.concatenate([grid, np.broadcast_to(z, shape)[..., None]], axis=-1)


def make_text(shape: TripodShape) -> str:
    """The robot file."""
    text = HEAD.format(above=shape.thickness + 0.001, radius=0.8 * shape.flat)
    end = shape.flat + shape.arm
    for k in range(3):
        angle = np.radians(120.0 * k)
        out, across = np.array([np.cos(angle), np.sin(angle)]), [-np.sin(angle), np.cos(angle)]
        x, y = (end - shape.horn - 1e-5) * out + 0.0
        px, py = (end + shape.axis) * out + 0.0
        text += DRIVE.format(
            name=f"servo{k}", x=x, y=y, nx=out[0], ny=out[1],
            tx=across[0], ty=across[1], px=px, py=py,
        )  # fmt: skip
    return text


def make_tripod(folder: Path) -> list[str]:
    """Write robot file and mesh into a folder; returns lines about them."""
    shape = TripodShape()
    (folder / "tripod.toml").write_text(make_text(shape), encoding="utf-8")
    return [write_mesh(folder / "tripod.vtu", *make_cells(shape))]
