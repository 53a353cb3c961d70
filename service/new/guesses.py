"""Guesses of what a mesh does not say: where it is held, where its cable runs, what is to reach targets.

They make a robot file that loads and moves; its comments ask the user to correct them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.mesh import TetMesh, boundary_triangles, triangle_areas
from tauten.model.numerics import Array
from tauten.model.points import attach

END = 0.02  # of the length; triangles so near an end belong to it
SLAB = (
    0.5  # of the smallest node spacing at the held end; half the thickness of the box that holds it
)
HANGS = 0.9  # the upper end is held unless the lower one is larger by more than this
STATIONS = 24  # points of the cable at most, evenly along the body
OFFSETS = (0.8, 0.65, 0.5, 0.35, 0.2)  # of the half width; the farther from the axis the better
PULL = 0.1  # of the length


@dataclass(frozen=True, slots=True)
class Guess:
    """Guessed fields of a robot file.

    Attributes:
        held: (2, 3) corners of the box whose nodes are held [m].
        cable: (p, 3) points of one cable [m].
        pull_point: (3,) where it leaves the body [m].
        effector: (3,) [m].
        outside: how far outside of a mesh of the part the points may lie [m].
        max_pull: [m].
    """

    held: Array
    cable: Array
    pull_point: Array
    effector: Array
    outside: float
    max_pull: float


def guess_fields(mesh: TetMesh) -> Guess:
    """Hold the larger end of the longest axis, pull along one side, move the other end.

    Args:
        mesh: the body.
    """
    low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
    axis = int(np.argmax(high - low))
    length = float(high[axis] - low[axis])
    triangles = boundary_triangles(mesh.tets)
    areas, centres = (
        triangle_areas(mesh.nodes, triangles),
        mesh.nodes[triangles].mean(axis=1)[:, axis],
    )
    at_low, at_high = centres < low[axis] + END * length, centres > high[axis] - END * length
    hold_high = float(areas[at_high].sum()) >= HANGS * float(areas[at_low].sum())
    held_at, free = (high[axis], at_low) if hold_high else (low[axis], at_high)
    corners = np.stack([low, high]) + 1e-3 * length * np.array([[-1.0], [1.0]])
    thickness = END * length * SLAB
    corners[:, axis] = (held_at - thickness, held_at + thickness)
    weights = areas[free] / areas[free].sum()
    effector = weights @ mesh.nodes[triangles[free]].mean(axis=1)
    cable = _cable(mesh, axis, low, high, hold_high)
    leaves = cable[0].copy()
    leaves[axis] = held_at + (END if hold_high else -END) * length
    return Guess(corners, cable, leaves, effector, 0.01 * length, PULL * length)


def _cable(mesh: TetMesh, axis: int, low: Array, high: Array, from_high: bool) -> Array:
    """Points of a cable from the held end to the free one, far from the weakest section: (p, 3) [m]."""
    along = low[axis] + (np.arange(STATIONS) + 0.5) / STATIONS * (high[axis] - low[axis])
    weak = _weakest_section(mesh, axis, low[axis], high[axis])
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    best, score = np.zeros((0, 3)), 0.0
    for across in (i for i in range(3) if i != axis):
        for offset in (side * share for side in (1.0, -1.0) for share in OFFSETS):
            points = np.tile(middle, (STATIONS, 1))
            points[:, axis] = along[::-1] if from_high else along
            points[:, across] += offset * half[across]
            inside = points[_inside(mesh, points)]
            lever = abs(middle[across] + offset * half[across] - weak[across])
            if len(inside) >= STATIONS // 3 and lever > (1.0 + 1e-6) * score:
                best, score = inside, lever
    if len(best):
        return best
    ends = [int(np.argmin(mesh.nodes[:, axis])), int(np.argmax(mesh.nodes[:, axis]))]
    return mesh.nodes[ends[::-1] if from_high else ends]  # a curved body, to be drawn by the user


def _weakest_section(mesh: TetMesh, axis: int, low: float, high: float) -> Array:
    """Centre of the slice across the axis with the least material, the ends left out: (3,) [m]."""
    centres, volumes = mesh.nodes[mesh.tets].mean(axis=1), mesh.volumes
    place = np.clip(
        ((centres[:, axis] - low) / (high - low) * STATIONS).astype(int), 0, STATIONS - 1
    )
    filled = np.bincount(place, volumes, minlength=STATIONS)[1:-1]
    chosen = place == 1 + int(np.argmin(np.where(filled > 0.0, filled, np.inf)))
    centre: Array = volumes[chosen] @ centres[chosen] / volumes[chosen].sum()
    return centre


def _inside(mesh: TetMesh, points: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which points (p, 3) lie in a tetrahedron: (p,)."""
    held = attach(mesh, points, "cable", np.inf)
    inside: np.ndarray[tuple[int], np.dtype[np.bool_]] = held.weights.min(axis=1) > 1e-6
    return inside
