"""Closed surfaces of triangles that a robot may touch: meshes, and fields of heights."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tauten.model.actuators import enclosed_volume, open_edges
from tauten.model.arguments import positive
from tauten.model.contact.shapes import vector
from tauten.model.contact.triangle_tree import signed_distances, triangle_tree
from tauten.model.mesh import UNITS, MeshError, read_triangles, welded
from tauten.model.numerics import Array, Ints

MOST_TRIANGLES = 1_000_000  # of a surface; a tree of more takes a minute
LARGEST_TABLE = 2**26  # bytes of a file of heights


class MeshShape:
    """What a closed surface encloses; cavities in it are outside."""

    def __init__(self, vertices: Array, triangles: Ints) -> None:
        """Of vertices (v, 3) [m] and triangles (t, 3) of these, counter-clockwise seen from outside.

        Raises:
            ValueError: the surface is not closed, is inside out, or has no volume.
        """
        edges = open_edges(triangles)
        if len(edges):
            where = vertices[edges[0]].mean(axis=0).round(4).tolist()
            raise ValueError(
                f"the surface of {len(triangles)} triangles is not closed: {len(edges)} edges, the first at "
                f"{where} m, do not join two triangles of the same orientation"
            )
        size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
        volume = enclosed_volume(vertices, triangles)
        if volume < -1e-12 * size**3:
            raise ValueError(
                f"the surface of {len(triangles)} triangles is inside out: it encloses {volume:.3g} m³; turn "
                "its triangles, so that they run round counter-clockwise seen from outside"
            )
        if not volume > 1e-12 * size**3:
            raise ValueError(f"the surface of {len(triangles)} triangles encloses no volume")
        self._vertices, self._triangles = vertices, triangles
        self._tree = triangle_tree(vertices, triangles)

    def closest(self, points: Array) -> tuple[Array, Array]:
        """Distances (m,) of points (m, 3) [m], and their gradients (m, 3)."""
        return self.closest_within(points, np.inf)

    def closest_within(self, points: Array, reach: float) -> tuple[Array, Array]:
        """As `closest`; the distance of points farther than `reach` [m] outside may be +inf."""
        return signed_distances(np.ascontiguousarray(points, dtype=float), self._tree, reach)

    def outline(self, centre: Array, extent: float) -> tuple[Array, Ints]:
        """Vertices (v, 3) [m] and triangles (t, 3) of the surface."""
        return self._vertices, self._triangles


def enclosed(vertices: Array, triangles: Ints) -> MeshShape | None:
    """What a surface (v, 3) [m], (t, 3) encloses; None where it is open, as tubes of beams are."""
    try:
        return MeshShape(vertices, triangles)
    except ValueError:
        return None


def mesh_of_file(folder: Path, file: str, length_unit: str = "m") -> MeshShape:
    """A closed surface of a file beside a robot file that meshio reads, as STL, of a unit "m", "cm" or "mm".

    Raises:
        ValueError: no such file or unit, no triangles, or a surface that is not closed or inside out.
    """
    path = path_in(folder, file)
    if length_unit not in UNITS:
        raise ValueError(
            f"length_unit: found {length_unit!r}, allowed are {', '.join(map(repr, UNITS))}"
        )
    points, corners = read_triangles(path)
    if len(corners) > MOST_TRIANGLES:
        raise ValueError(
            f"{path}: the surface has {len(corners)} triangles, allowed are {MOST_TRIANGLES}; export it "
            "with a larger deviation"
        )
    vertices, triangles = welded(UNITS[length_unit] * points[corners])
    if not len(triangles):
        raise MeshError(f"{path}: each triangle has two corners at the same point")
    try:
        return MeshShape(vertices, triangles)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def heights_of_file(
    folder: Path,
    corner: Array,
    spacing: Array,
    thickness: float,
    heights: Array | None = None,
    file: str | None = None,
) -> MeshShape:
    """A field of heights: a body with a flat bottom, whose top has a height z at each node of a grid.

    Between nodes each cell has two triangles. Heights are given in the robot file or in a file of text, a
    line for each x with the numbers for each y, separated by commas or spaces.

    Args:
        folder: of the robot file.
        corner: (3,) the node with the least x and y; heights are above its z [m].
        spacing: (2,) of the nodes along x and y [m].
        thickness: of the body below the lowest node [m].
        heights: (x, y) above the corner [m].
        file: of them instead, a path relative to the folder.

    Raises:
        ValueError: not one of `heights` and `file`, no table of two by two finite numbers or more, or a
            spacing or thickness that is not positive.
    """
    if (heights is None) == (file is None):
        raise ValueError(
            "heights: give them as a table, or the name of a file of them, and not both"
        )
    where = "heights"
    if file is not None:
        path = path_in(folder, file)
        where = f"file: {path}"
        heights = _table(path)
    field = np.asarray(heights, dtype=float)
    if field.ndim != 2 or min(field.shape) < 2 or not np.isfinite(field).all():
        raise ValueError(
            f"{where}: expected a table of at least two by two finite numbers, found one of "
            f"{' by '.join(map(str, field.shape))}"
            + ("" if np.isfinite(field).all() else " with numbers that are not finite")
        )
    if 2 * field.size > MOST_TRIANGLES:
        raise ValueError(f"{where}: {field.size} heights, allowed are {MOST_TRIANGLES // 2}")
    if np.shape(spacing) != (2,):
        raise ValueError(f"spacing: expected two numbers [m], found {np.asarray(spacing).tolist()}")
    steps = [positive("spacing", float(one)) for one in spacing]
    low = float(field.min()) - positive("thickness", thickness)
    return MeshShape(*_extruded(vector("corner", corner), steps, field, low))


def _extruded(corner: Array, steps: list[float], heights: Array, low: float) -> tuple[Array, Ints]:
    """Vertices and triangles of a field of heights (x, y) above a flat bottom at the height `low`.

    Args:
        corner: (3,) of the grid [m].
        steps: along x and y [m].
        heights: above the corner [m].
        low: likewise.
    """
    nx, ny = heights.shape
    i, j = np.indices((nx, ny))
    flat = np.stack([steps[0] * i, steps[1] * j], axis=2)  # (x, y, 2)
    layers = [np.dstack([flat, z]).reshape(-1, 3) for z in (heights, np.full((nx, ny), low))]
    number = np.arange(nx * ny).reshape(nx, ny)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    top = np.concatenate([_rows(a, b, c), _rows(a, c, d)])
    bottom = top[:, ::-1] + nx * ny
    # the border, counter-clockwise seen from above
    around = np.concatenate([number[:, 0], number[-1, 1:], number[-2::-1, -1], number[0, -2:0:-1]])
    beside = np.roll(around, -1)
    down, below = around + nx * ny, beside + nx * ny
    walls = np.concatenate([_rows(around, down, below), _rows(around, below, beside)])
    return corner + np.concatenate(layers), np.concatenate([top, bottom, walls])


def _rows(*columns: Ints) -> Ints:
    """Triangles (t, 3) of three arrays of as many numbers."""
    return np.stack([column.ravel() for column in columns], axis=1)


def _table(path: Path) -> Array:
    """Numbers of a file of text, line by line: (r, c)."""
    if path.stat().st_size > LARGEST_TABLE:
        raise ValueError(
            f"file: {path} has {path.stat().st_size} bytes, allowed are {LARGEST_TABLE}"
        )
    try:
        lines = path.read_text(encoding="utf-8").replace(",", " ").splitlines()
        rows = [[float(one) for one in line.split()] for line in lines if line.strip()]
    except ValueError as error:
        raise ValueError(f"file: {path} is no table of numbers ({error})") from error
    if not rows:
        raise ValueError(f"file: {path} has no heights")
    if len({len(row) for row in rows}) != 1:
        raise ValueError(f"file: {path}: its lines have different numbers of heights")
    return np.array(rows)


def path_in(folder: Path, file: object) -> Path:
    """The path of a file that a robot file in a folder names.

    Raises:
        ValueError: this is no text, or there is no such file.
    """
    if not isinstance(file, str) or "\0" in file:
        raise ValueError(f"file: expected the name of a file, found {file!r}")
    path = folder / file
    if not path.is_file():
        raise ValueError(f"file: {path}: no such file")
    return path
