"""The part that becomes a robot's body: a surface, a solid or tetrahedra in a file, in metres."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from tauten.model.actuators import enclosed_volume
from tauten.model.mesh import read_triangles
from tauten.model.numerics import Array, Ints

SURFACES = (".stl", ".obj", ".ply")
SOLIDS = (".step", ".stp", ".brep")
Kind = Literal["surface", "solid", "tetrahedra"]
SAME_POINT = 1e-7  # of the size; STL repeats the corners of its triangles


class PartError(ValueError):
    """A part that cannot become a body; the text names the file and the next step."""


@dataclass(frozen=True, slots=True)
class Surface:
    """A closed surface, seen from outside counter-clockwise.

    Attributes:
        vertices: (v, 3) in the unit of the file.
        triangles: (t, 3) vertex ids.
        note: what was changed in it; "" for nothing.
    """

    vertices: Array
    triangles: Ints
    note: str = ""

    @property
    def volume(self) -> float:
        """Enclosed volume, in the unit of the file."""
        return enclosed_volume(self.vertices, self.triangles)


def kind_of(path: Path) -> Kind:
    """What a file holds, by its suffix; everything that is no surface and no solid is read by meshio."""
    suffix = path.suffix.lower()
    if suffix in SURFACES:
        return "surface"
    return "solid" if suffix in SOLIDS else "tetrahedra"


def read_surface(path: Path, repair: bool) -> Surface:
    """Read a closed surface.

    Args:
        path: STL, OBJ or PLY.
        repair: whether holes and intersections are left to the mesher, which then closes them.

    Raises:
        MeshError: unreadable file, no triangles, or numbers that are not finite.
        PartError: holes, parts inside out relative to one another, self-intersections.
    """
    points, corners = read_triangles(path)
    vertices, triangles = welded(points[corners])
    if repair:
        return Surface(vertices, triangles, "repaired by the mesher")
    refuse_holes(path, triangles)
    note = ""
    if enclosed_volume(vertices, triangles) < 0.0:
        triangles, note = triangles[:, ::-1].copy(), "was inside out and has been turned"
    crossing = first_crossing(vertices, triangles)
    if crossing is not None:
        where = np.round(vertices[triangles[crossing[0]]].mean(axis=0), 4).tolist()
        raise PartError(
            f"{path}: triangles {crossing[0]} and {crossing[1]} cross each other near {where} (unit of the "
            "file); mend the surface in CAD, or let the mesher do it with --repair"
        )
    return Surface(vertices, triangles, note)


def welded(corners: Array) -> tuple[Array, Ints]:
    """Vertices (v, 3) and triangles (t, 3) of triangles (t, 3, 3) that repeat their corners."""
    points = corners.reshape(-1, 3)
    step = SAME_POINT * max(float(np.ptp(points, axis=0).max()), np.finfo(float).tiny)
    _, first, number = np.unique(
        np.round(points / step).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    triangles = number.reshape(-1, 3)
    a, b, c = triangles.T
    return points[first], triangles[(a != b) & (b != c) & (a != c)]


def refuse_holes(path: Path, triangles: Ints) -> None:
    """Raise a PartError unless each edge has two triangles that pass it in opposite directions."""
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])  # (3 t, 2)
    _, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    advice = "close the surface in CAD, or let the mesher do it with --repair"
    if (count == 1).any():
        raise PartError(
            f"{path}: the surface has holes, {int((count == 1).sum())} edges have one triangle; {advice}"
        )
    if (count > 2).any():
        raise PartError(
            f"{path}: {int((count > 2).sum())} edges have more than two triangles; {advice}"
        )
    _, turned = np.unique(edges, axis=0, return_counts=True)
    if (turned > 1).any():
        raise PartError(
            f"{path}: some triangles are inside out beside others, {int((turned > 1).sum())} edges; {advice}"
        )


def first_crossing(vertices: Array, triangles: Ints) -> tuple[int, int] | None:
    """Two triangles of a surface that cross each other and share no vertex; None where there are none.

    An edge of one has to pass through the other (Möller and Trumbore 1997).

    Args:
        vertices: (v, 3).
        triangles: (t, 3).
    """
    corners = vertices[triangles]  # (t, 3, 3)
    low, high = corners.min(axis=1), corners.max(axis=1)
    order = np.argsort(low[:, 0])
    starts = low[order, 0]
    for place, index in enumerate(order):
        end = int(np.searchsorted(starts, high[index, 0], side="right"))
        others = order[place + 1 : end]
        overlap = (low[others] <= high[index]).all(axis=1) & (high[others] >= low[index]).all(
            axis=1
        )
        others = others[overlap]
        apart = ~np.isin(triangles[others], triangles[index]).any(axis=1)
        others = others[apart]
        if not len(others):
            continue
        hit = pierced(corners[index][None], corners[others]) | pierced(
            corners[others], corners[index][None]
        )
        if hit.any():
            return int(index), int(others[int(hit.argmax())])
    return None


def pierced(edges_of: Array, through: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Whether an edge of one triangle passes through another, pair by pair.

    Args:
        edges_of: (p, 3, 3) or (1, 3, 3) triangles whose edges are used.
        through: (p, 3, 3) or (1, 3, 3) triangles.
    """
    edge1, edge2 = through[:, 1] - through[:, 0], through[:, 2] - through[:, 0]
    found = np.zeros(max(len(edges_of), len(through)), dtype=bool)
    for i in range(3):
        start = edges_of[:, i]
        direction = edges_of[:, (i + 1) % 3] - start
        p = np.cross(direction, edge2)
        scale = np.einsum("...i,...i->...", edge1, p)
        with np.errstate(all="ignore"):  # parallel ones give inf or nan, which no comparison passes
            s = start - through[:, 0]
            u = np.einsum("...i,...i->...", s, p) / scale
            q = np.cross(s, edge1)
            v = np.einsum("...i,...i->...", direction, q) / scale
            t = np.einsum("...i,...i->...", edge2, q) / scale
            found |= (u > 0.0) & (v > 0.0) & (u + v < 1.0) & (t > 0.0) & (t < 1.0)
    return found
