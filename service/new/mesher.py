"""The mesher's process: `python -P mesher.py KIND FILE SIZE OUT`.

KIND is `surface` or `solid` (netgen), `repair` (fTetWild), or `facts` about a solid. Lengths are in the unit
of the file. OUT is an npz file with `nodes` and `tets`, or with the facts.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

# Of solids: how fine curved faces and short edges are meshed beside the size, netgen's own values being 2
# and 1. Those took a part with a hole of 1.6 mm from 311 to 11,000 nodes.
COARSE = {"curvaturesafety": 0.5, "segmentsperedge": 0.3}
EMPTY = "Bnd_Box is void"  # what netgen says of a file without geometry
LOST = 0.03  # of a solid's volume, which a mesh of coarse details may lack or have too much


def netgen_mesh(kind: str, file: str, size: float) -> dict[str, Any]:
    """Tetrahedra by netgen: nodes (n, 3) and tets (e, 4).

    Details of a solid smaller than the elements are meshed coarsely, unless the mesh has another volume then.

    Args:
        kind: "surface" or "solid".
        file: STL, STEP or BREP.
        size: longest edge, in the unit of the file.
    """
    if kind == "surface":
        from netgen.stl import STLGeometry

        return arrays_of(STLGeometry(file).GenerateMesh(maxh=size))
    from netgen.occ import OCCGeometry

    with suppress(Exception):  # netgen's own class of errors; it cannot mesh some details coarsely
        geometry = OCCGeometry(file)
        exact = sum(solid.mass for solid in geometry.shape.solids)
        coarse = arrays_of(geometry.GenerateMesh(maxh=size, **COARSE))
        if abs(volume_of(coarse) - exact) < LOST * exact:
            return coarse
    return arrays_of(OCCGeometry(file).GenerateMesh(maxh=size))


def arrays_of(mesh: Any) -> dict[str, Any]:
    """Nodes (n, 3) and tets (e, 4) of a mesh of netgen.

    Raises:
        ValueError: netgen has filled the surface with none, without an error.
    """
    nodes = np.array([point.p for point in mesh.Points()])
    tets = np.array(
        [[vertex.nr - 1 for vertex in element.vertices] for element in mesh.Elements3D()]
    )
    if not len(tets):
        raise ValueError("netgen fills the surface with no tetrahedra")
    return {"nodes": nodes, "tets": tets}


def volume_of(mesh: dict[str, Any]) -> float:
    """Volume of all tetrahedra, in the unit of the file."""
    corners = mesh["nodes"][mesh["tets"]]  # (e, 4, 3)
    a, b, c = (corners[:, i] - corners[:, 0] for i in (1, 2, 3))
    return float(np.abs(np.einsum("ei,ei->e", a, np.cross(b, c))).sum()) / 6.0


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
    """Number of solids, volume and bounding box (2, 3) of what a STEP or BREP file holds.

    The box of no solid is zero; netgen's box of an empty file is an error.
    """
    from netgen.occ import OCCGeometry

    none = {"solids": 0, "volume": 0.0, "box": np.zeros((2, 3))}
    try:
        shape = OCCGeometry(file).shape
    except RuntimeError as error:
        if EMPTY in str(error):
            return none
        raise
    if not len(shape.solids):
        return none
    low, high = (np.array([point.x, point.y, point.z]) for point in shape.bounding_box)
    volume = sum(solid.mass for solid in shape.solids)
    return {"solids": len(shape.solids), "volume": volume, "box": np.array([low, high])}


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
