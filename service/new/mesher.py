"""The mesher's process: `python -P mesher.py KIND FILE SIZE OUT`.

KIND is `surface` or `solid` (netgen), `repair` (fTetWild), or `facts` about a solid. Lengths are in the unit
of the file. OUT is an npz file with `nodes` and `tets`, or with the facts.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np


def netgen_mesh(kind: str, file: str, size: float) -> dict[str, Any]:
    """Tetrahedra by netgen: nodes (n, 3) and tets (e, 4).

    Args:
        kind: "surface" or "solid".
        file: STL, STEP or BREP.
        size: longest edge, in the unit of the file.
    """
    if kind == "surface":
        from netgen.stl import STLGeometry

        geometry = STLGeometry(file)
    else:
        from netgen.occ import OCCGeometry

        geometry = OCCGeometry(file)
    mesh = geometry.GenerateMesh(maxh=size)
    nodes = np.array([point.p for point in mesh.Points()])
    tets = np.array(
        [[vertex.nr - 1 for vertex in element.vertices] for element in mesh.Elements3D()]
    )
    return {"nodes": nodes, "tets": tets}


def repaired_mesh(file: str, size: float) -> dict[str, Any]:
    """Tetrahedra by fTetWild, which accepts holes and crossings."""
    import meshio
    import wildmeshing

    raw = meshio.read(file)
    vertices = np.asarray(raw.points, dtype=float)
    triangles = np.vstack([block.data for block in raw.cells if block.type == "triangle"])
    mesher = wildmeshing.Tetrahedralizer(
        edge_length_r=size / float(np.linalg.norm(np.ptp(vertices, axis=0))), coarsen=False
    )
    mesher.set_mesh(vertices, triangles.astype(np.int32))
    mesher.tetrahedralize()
    nodes, tets = mesher.get_tet_mesh(correct_surface_orientation=True)[:2]
    used, numbers = np.unique(tets, return_inverse=True)
    return {"nodes": nodes[used], "tets": numbers.reshape(-1, 4)}


def solid_facts(file: str) -> dict[str, Any]:
    """Number of solids, volume and longest side of what a STEP or BREP file holds."""
    from netgen.occ import OCCGeometry

    shape = OCCGeometry(file).shape
    low, high = (np.array([point.x, point.y, point.z]) for point in shape.bounding_box)
    volume = sum(solid.mass for solid in shape.solids)
    return {"solids": len(shape.solids), "volume": volume, "length": float((high - low).max())}


def main(arguments: list[str]) -> None:
    """Do what the command line says."""
    kind, file, size, out = arguments
    if kind == "facts":
        found = solid_facts(file)
    elif kind == "repair":
        found = repaired_mesh(file, float(size))
    else:
        found = netgen_mesh(kind, file, float(size))
    np.savez(Path(out), **found)


if __name__ == "__main__":
    main(sys.argv[1:])
