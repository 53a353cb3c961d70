"""Mesh files as meshio reads them, what shows that one is cut off, and surfaces as triangles."""

from __future__ import annotations

import re
import struct
import tempfile
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from tauten.model.numerics import Array, Ints
from tauten.model.printing import kept_from_terminal

ENDS = {".ply": b"end_header", ".vtu": b"</VTKFile>", ".msh": b"$EndElements"}  # by suffix
STARTS = {".msh": b"$MeshFormat"}  # of the format that has this end, where a suffix has several
STL_HEADER, STL_TRIANGLE = 84, 50  # bytes
POLYGONS = ("triangle", "quad", "polygon")  # what meshio calls the faces of surfaces


class MeshError(ValueError):
    """A mesh that cannot be used for a robot; the text names the file and what to change."""


def read_with_meshio(path: Path) -> Any:
    """The `meshio.Mesh` of a file.

    Raises:
        MeshError: no such file, a suffix of no mesh format, a file that is cut off or that meshio cannot
            read; the text contains the reason on one line.
    """
    if not path.is_file():
        what = "is a folder, expected a" if path.is_dir() else "no such"
        raise MeshError(f"{' '.join(str(path).splitlines())}: {what} mesh file")
    if path.suffix.lower() not in meshio.extension_to_filetypes:
        raise MeshError(
            f"{path}: no mesh format has the suffix {path.suffix!r}; export tetrahedra as VTU, VTK or MSH, "
            "a surface as STL, OBJ or PLY; `tauten new` takes solids as STEP or BREP"
        )
    with (
        kept_from_terminal() as printed,
        np.errstate(over="ignore"),  # a text STL whose first bytes meshio multiplies as a size
    ):
        try:
            return _read(path)
        except MeshError:
            raise
        except OSError as error:
            raise unreadable(path, error.strerror or meshio_says(str(error))) from error
        except SystemExit as error:  # meshio has printed why it cannot read the file
            raise unreadable(path, meshio_says(printed.getvalue())) from error
        except Exception as error:
            raise unreadable(path, meshio_says(str(error) or type(error).__name__)) from error


def unreadable(path: Path, reason: str) -> MeshError:
    """The error of a file that is not read, for this reason."""
    return MeshError(f"{path}: not readable as a mesh ({reason}); export it again")


def meshio_says(text: str) -> str:
    """The reason of a file that meshio does not read, with the text of its error on one line."""
    words = " ".join(text.split())
    return "it is cut off, damaged or of another format" + (words and f"; meshio: {words}")


def _read(path: Path) -> Any:
    contents, suffix = path.read_bytes(), path.suffix.lower()
    reason = why_not_whole(contents, suffix)
    if reason:
        raise unreadable(path, reason)
    if suffix == ".obj":
        return _surface_of_obj(path)
    if suffix != ".vtk":
        return meshio.read(path)
    raw = meshio.read(path, "vtu" if contents.lstrip().startswith(b"<") else None)
    reason = missing_cells(contents, sum(len(block.data) for block in raw.cells))
    if reason:
        raise unreadable(path, reason)
    return raw


def _surface_of_obj(path: Path) -> Any:
    """The `meshio.Mesh` of the vertices and faces in an OBJ file.

    meshio refuses files whose texture has another number of points than the surface, does not know numbers
    that count from the last vertex, and takes colours of vertices for coordinates.
    """
    lines, vertices = list[str](), 0
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        kind, *items = line.split() or [""]
        if kind == "v":
            vertices += 1
            lines.append(" ".join(["v", *items[:3]]))
        elif kind == "f":
            numbers = [int(item.split("/")[0]) for item in items]
            lines.append(" ".join(["f", *(str(n if n > 0 else vertices + 1 + n) for n in numbers)]))
    with tempfile.TemporaryDirectory(prefix="tauten-") as folder:
        plain = Path(folder) / "surface.obj"
        plain.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return meshio.read(plain)


def kinds_of(raw: Any) -> set[str]:
    """The kinds of cells in a `meshio.Mesh`."""
    return {block.type for block in raw.cells if len(block.data)}


def read_triangles(path: Path) -> tuple[Array, Ints]:
    """Vertices (v, 3), in the unit of the file, and triangles (t, 3) of a surface such as an STL file.

    Faces with more corners are divided.

    Raises:
        MeshError: unreadable file, no faces, coordinates that are not finite, or corners that are no
            vertices.
    """
    raw = read_with_meshio(path)
    parts = [
        np.asarray(block.data)[:, [0, i, i + 1]]
        for block in raw.cells
        if block.type in POLYGONS
        for i in range(1, np.asarray(block.data).shape[1] - 1)
    ]
    if not sum(len(part) for part in parts):
        raise MeshError(f"{path}: no triangles found")
    points, triangles = np.asarray(raw.points, dtype=float), np.concatenate(parts).astype(np.int64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError(
            f"{path}: vertices are an array {points.shape}, expected three coordinates each"
        )
    if not np.isfinite(points).all():
        raise MeshError(f"{path}: a vertex is not finite; export the surface again")
    wrong = np.flatnonzero(((triangles < 0) | (triangles >= len(points))).any(axis=1))
    if len(wrong):
        raise MeshError(
            f"{path}: {len(wrong)} of {len(triangles)} triangles have corners that are none of the "
            f"{len(points)} vertices, the first is triangle {wrong[0]}; export the surface again, as STL"
        )
    return points, triangles


def why_not_whole(contents: bytes, suffix: str) -> str:
    """Why a file cannot be a whole mesh file of the format that its suffix names; "" if nothing shows it."""
    if not contents.strip():
        return "it is empty"
    if suffix == ".stl":
        return _why_no_stl(contents)
    if suffix in ENDS and STARTS.get(suffix, b"") in contents and ENDS[suffix] not in contents:
        return f"it is cut off, or of another format: '{ENDS[suffix].decode()}' is missing"
    return ""


def missing_cells(contents: bytes, found: int) -> str:
    """Why a VTK file of which this number of cells has been read is not whole; "" if nothing shows it."""
    said = re.search(rb"\nCELL_TYPES\s+(\d+)", contents)
    if said is None or found >= int(said[1]):
        return ""
    return f"it is cut off: it has {found} of {int(said[1])} cells"


def _why_no_stl(contents: bytes) -> str:
    """The same for the contents of an STL file: text ends with a word, binary files count their triangles."""
    binary = len(contents) >= STL_HEADER
    count = struct.unpack_from("<I", contents, STL_HEADER - 4)[0] if binary else 0
    expected = STL_HEADER + STL_TRIANGLE * count
    if binary and len(contents) == expected:
        return ""
    if contents.lstrip().startswith(b"solid") and b"\0" not in contents:
        return "" if b"endsolid" in contents else "it is cut off: 'endsolid' is missing"
    if not binary:
        return f"it has {len(contents)} bytes, the header of an STL file has {STL_HEADER}"
    return (
        f"it is cut off, or no STL file: it has {len(contents)} bytes, the {count} triangles that its "
        f"header counts need {expected}"
    )
