"""A guessed cable that follows one side of a body from the held end to the free one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import grey_closing

from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Bools
from tauten.model.points import attach

STATIONS = 24  # points of the cable at most, evenly along the body
DEPTHS = 24  # points of a section that are looked at, from one side to the other
INSET = 0.1  # of the width of a section; how far below its surface the cable runs
NOTCH = 7  # stations; a gap in the side as long as that is spanned, a longer one is followed
ALIKE = 0.05  # relative; sides whose cables have levers so near to each other are alike
STEP = 0.05  # of the width of the body; where the side is deeper than that, it is a notch


@dataclass(frozen=True, slots=True)
class Axes:
    """The body's directions.

    Attributes:
        axis: coordinate along the body.
        low, high: (3,) corners of its bounding box [m].
        from_high: whether the end at the high coordinate is held.
    """

    axis: int
    low: Array
    high: Array
    from_high: bool

    @property
    def length(self) -> float:
        """Of the body [m]."""
        return float(self.high[self.axis] - self.low[self.axis])


def side_cable(mesh: TetMesh, axes: Axes) -> Array:
    """Points of a cable from the held end to the free one, far from the weakest section: (p, 3) [m]."""
    weak = weakest_section(mesh, axes)
    best, score = np.zeros((0, 3)), 0.0
    sides = [(2, 1.0), (0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, -1.0)]
    for across, side in sides:  # where sides are alike, one that lifts the body against gravity
        if across == axes.axis:
            continue
        points = along_side(mesh, axes, across, side)
        if len(points) < STATIONS // 3:
            continue
        lever = abs(float(points[:, across].mean()) - weak[across])
        reached = lever * float(np.ptp(points[:, axes.axis])) / axes.length
        if reached > (1.0 + ALIKE) * score:
            best, score = points, reached
    if len(best):
        return best
    ends = [int(np.argmin(mesh.nodes[:, axes.axis])), int(np.argmax(mesh.nodes[:, axes.axis]))]
    return mesh.nodes[ends[::-1] if axes.from_high else ends]  # to be drawn by the user


def along_side(mesh: TetMesh, axes: Axes, across: int, side: float) -> Array:
    """Points (p, 3) a little below one side of the body, from the held end to the free one [m].

    Notches are spanned. Points stand where the body is.

    Args:
        mesh: the body.
        axes: its directions.
        across: coordinate that the side belongs to.
        side: 1 for the side of larger coordinates, −1 for the other one.
    """
    grid, widths = sections(mesh, axes, across)  # (s, d, 3), (s,)
    inside = in_mesh(mesh, grid.reshape(-1, 3)).reshape(grid.shape[:2])
    height = side * grid[:, :, across]  # (s, d)
    surface = np.where(inside, height, -np.inf).max(axis=1)  # (s,)
    there = np.isfinite(surface)
    if not there.any():
        return np.zeros((0, 3))
    lowest = float(surface[there].min())
    spanned = grey_closing(np.where(there, surface, lowest), size=NOTCH, mode="nearest")
    kept = there & (surface > spanned - STEP * float(np.ptp(mesh.nodes[:, across])))
    points = grid[:, 0].copy()
    points[:, across] = side * (surface - INSET * widths)
    points = points[kept]
    points_in: Array = points[in_mesh(mesh, points)]
    return points_in[::-1] if axes.from_high else points_in


def sections(mesh: TetMesh, axes: Axes, across: int) -> tuple[Array, Array]:
    """Points across the body at each station (s, d, 3), and how wide it is there (s,) [m].

    They lie in the middle of the body's section, as seen in the third direction.
    """
    third = 3 - axes.axis - across
    share = (np.arange(STATIONS) + 0.5) / STATIONS
    along = axes.low[axes.axis] + share * axes.length
    corners = mesh.nodes[mesh.tets]  # (e, 4, 3)
    low, high = corners.min(axis=1), corners.max(axis=1)
    grid, widths = np.zeros((STATIONS, DEPTHS, 3)), np.zeros(STATIONS)
    for station, place in enumerate(along):
        cut = (low[:, axes.axis] <= place) & (high[:, axes.axis] >= place)
        if not cut.any():
            widths[station] = np.nan
            continue
        least, most = float(low[cut, across].min()), float(high[cut, across].max())
        middle = 0.5 * (float(low[cut, third].min()) + float(high[cut, third].max()))
        grid[station, :, axes.axis], grid[station, :, third] = place, middle
        grid[station, :, across] = least + (np.arange(DEPTHS) + 0.5) / DEPTHS * (most - least)
        widths[station] = most - least
    return grid, widths


def weakest_section(mesh: TetMesh, axes: Axes) -> Array:
    """Centre of the slice across the axis with the least material, the ends left out: (3,) [m]."""
    centres, volumes = mesh.nodes[mesh.tets].mean(axis=1), mesh.volumes
    along = (centres[:, axes.axis] - axes.low[axes.axis]) / axes.length
    place = np.clip((along * STATIONS).astype(int), 0, STATIONS - 1)
    filled = np.bincount(place, volumes, minlength=STATIONS)[1:-1]
    chosen = place == 1 + int(np.argmin(np.where(filled > 0.0, filled, np.inf)))
    centre: Array = volumes[chosen] @ centres[chosen] / volumes[chosen].sum()
    return centre


def in_mesh(mesh: TetMesh, points: Array) -> Bools:
    """Which points (p, 3) lie in a tetrahedron: (p,)."""
    if not len(points):
        return np.zeros(0, np.bool_)
    held = attach(mesh, points, "cable", np.inf)
    inside: Bools = held.weights.min(axis=1) > 1e-6
    return inside
