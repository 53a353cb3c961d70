"""Tetrahedral meshes: reading, the checks that make a mesh usable, uniform refinement."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from tauten.model.mesh.groups import CellGroup, NodeNumbers, divided, read_groups
from tauten.model.mesh.mesh_files import MeshError, kinds_of, read_with_meshio
from tauten.model.mesh.surface import FACES
from tauten.model.numerics import Array, Ints, diameter, row_keys
from tauten.model.schema import LARGEST_COORDINATE

EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])  # of corners, in VTK's order
SHOWN_BODIES = 5  # beside the largest, in an error
log = logging.getLogger(__name__)
UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}


@dataclass(frozen=True, slots=True)
class TetMesh:
    """A body of linear tetrahedra.

    Attributes:
        nodes: (n_nodes, 3) rest positions [m].
        tets: (e, 4) node ids, positively oriented.
        groups: cells that the mesh file names.
        numbers: of the nodes in the file; None: there is none, or there are several.
        size: largest distance between two nodes [m].
    """

    nodes: Array
    tets: Ints
    groups: tuple[CellGroup, ...] = ()
    numbers: NodeNumbers | None = None
    size: float = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", diameter(self.nodes))

    @property
    def volumes(self) -> Array:
        """Signed volume of every tetrahedron: (e,) [m³]."""
        return signed_volumes(self.nodes, self.tets)

    def inverted(self, x: Array) -> int:
        """Number of tetrahedra that are turned inside out at nodes x (n_nodes, 3) [m]."""
        return int((signed_volumes(x, self.tets) < 0.0).sum())

    def refine(self) -> TetMesh:
        """Every tetrahedron cut into eight through its edge midpoints."""
        nodes, tets, ends = with_midpoints(self.nodes, self.tets)
        numbers = self.numbers and self.numbers.with_middles(ends)
        return eight_parts(nodes, tets, self.groups, numbers)


def join_meshes(meshes: list[TetMesh]) -> TetMesh:
    """Several meshes as one, in their order; groups of the same name become one group."""
    if len(meshes) == 1:
        return meshes[0]
    nodes = np.cumsum([0, *(len(mesh.nodes) for mesh in meshes)])
    tets = np.cumsum([0, *(len(mesh.tets) for mesh in meshes)])
    groups: dict[str, list[CellGroup]] = {}
    for mesh, first_node, first_tet in zip(meshes, nodes, tets, strict=False):
        for group in mesh.groups:
            moved = CellGroup(group.name, group.tets + first_tet, group.triangles + first_node)
            groups.setdefault(group.name, []).append(moved)
    return TetMesh(
        np.concatenate([mesh.nodes for mesh in meshes]),
        np.concatenate([mesh.tets + first for mesh, first in zip(meshes, nodes, strict=False)]),
        tuple(
            CellGroup(
                name,
                np.concatenate([part.tets for part in parts]),
                np.concatenate([part.triangles for part in parts]),
            )
            for name, parts in groups.items()
        ),
    )


def with_midpoints(nodes: Array, tets: Ints) -> tuple[Array, Ints, Ints]:
    """Nodes with the midpoints of all edges added.

    Returns:
        The nodes, the tetrahedra (e, 10) with the midpoints on their `EDGES`, and the edges (k, 2).
    """
    edges = np.sort(tets[:, EDGES], axis=2).reshape(-1, 2)  # (6 e, 2)
    _, first, inverse = np.unique(row_keys(edges), return_index=True, return_inverse=True)
    middle = len(nodes) + inverse.reshape(-1, 6)  # (e, 6)
    ends = edges[first]  # (k, 2)
    every = np.vstack([nodes, nodes[ends].mean(axis=1)])
    return every, np.concatenate([tets, middle], axis=1), ends


def eight_parts(
    nodes: Array, tets: Ints, groups: tuple[CellGroup, ...], numbers: NodeNumbers | None
) -> TetMesh:
    """Tetrahedra with mid-edge nodes, cut into eight (Bey's red refinement).

    Args:
        nodes: (n_nodes, 3) positions [m].
        tets: (e, 10) corners, then the nodes on their `EDGES`.
        groups: of these tetrahedra and their faces.
        numbers: of the nodes in the file.
    """
    a, b, c, d, ab, bc, ac, ad, bd, cd = tets.T
    children = [
        (a, ab, ac, ad), (ab, b, bc, bd), (ac, bc, c, cd), (ad, bd, cd, d),
        (ab, ac, ad, bd), (ab, ac, bd, bc), (ac, ad, bd, cd), (ac, bc, cd, bd),
    ]  # fmt: skip
    parts = np.stack([np.stack(child, axis=1) for child in children], axis=1).reshape(-1, 4)
    edges, middle = np.sort(tets[:, EDGES], axis=2).reshape(-1, 2), tets[:, 4:].ravel()
    smaller = tuple(divided(group, edges, middle) for group in groups)
    return TetMesh(nodes, oriented(nodes, parts), smaller, numbers)


def signed_volumes(nodes: Array, tets: Ints) -> Array:
    """Signed volume of each tetrahedron: (e,) [m³]."""
    edges = nodes[tets[:, 1:]] - nodes[tets[:, :1]]  # (e, 3, 3)
    with np.errstate(all="ignore"):  # edges of denormal length: `checked` finds these flat
        volumes: Array = np.linalg.det(edges) / 6.0
    return volumes


def oriented(nodes: Array, tets: Ints) -> Ints:
    """The same tetrahedra with two corners swapped where the volume is negative: (e, 4)."""
    tets = tets.copy()
    flipped = signed_volumes(nodes, tets) < 0.0
    tets[flipped] = tets[flipped][:, [0, 2, 1, 3]]
    return tets


def read_mesh(path: Path, length_unit: str = "m", overlaps: bool = False) -> TetMesh:
    """Read the tetrahedra of any format that meshio supports (.msh, .vtk, .vtu, ...).

    Args:
        path: the mesh file.
        length_unit: unit of its coordinates, one of "m", "cm", "mm".
        overlaps: whether tetrahedra may occupy the same space.

    Returns:
        The mesh in metres; nodes that no tetrahedron uses are dropped, other cells ignored.

    Raises:
        MeshError: unreadable file, no tetrahedra, corners that are no nodes, or what `checked` refuses.
    """
    raw = read_with_meshio(path)
    kinds = kinds_of(raw)
    if "tetra10" in kinds:
        raise MeshError(
            f'{path}: holds quadratic tetrahedra; set mesh.element = "quadratic" in the robot file'
        )
    if "tetra" not in kinds:
        found = "only " + ", ".join(sorted(kinds)) if kinds else "and no other cells"
        raise MeshError(f"{path}: no tetrahedra found, {found}; mesh the volume")
    nodes, tets, groups, numbers = used_nodes(raw, "tetra", length_unit, path)
    return replace(checked(nodes, tets, str(path), overlaps), groups=groups, numbers=numbers)


def used_nodes(
    raw: Any, kind: str, length_unit: str, path: Path
) -> tuple[Array, Ints, tuple[CellGroup, ...], NodeNumbers]:
    """Nodes (n_nodes, 3) [m] that cells of one kind use, these cells (e, corners), their groups, and numbers.

    Raises:
        MeshError: points that are no coordinates, or corners that are no nodes.
    """
    blocks = [np.asarray(block.data) for block in raw.cells if block.type == kind]
    points, tets = np.asarray(raw.points), np.vstack([block for block in blocks if len(block)])
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "iuf":
        raise MeshError(
            f"{path}: points are an array {points.shape} of {points.dtype}, expected three coordinates each"
        )
    if tets.dtype.kind not in "iu":
        raise MeshError(f"{path}: corners of tetrahedra are {tets.dtype}, expected integers")
    wrong = np.flatnonzero(((tets < 0) | (tets >= len(points))).any(axis=1))
    if len(wrong):
        raise MeshError(
            f"{path}: tetrahedron {wrong[0]} has the corners {tets[wrong[0]].tolist()}, "
            f"the nodes are 0 to {len(points) - 1}"
        )
    used, numbers = np.unique(tets.astype(np.int64), return_inverse=True)
    with np.errstate(over="ignore"):  # too large values become infinite, which `checked` refuses
        nodes = points[used].astype(np.float64) * UNITS[length_unit]
    groups = read_groups(raw, kind, used)
    return nodes, numbers.reshape(tets.shape), groups, NodeNumbers(used)


def require_size(points: Array, scale: float, source: str, fields: str) -> None:
    """Raise a MeshError unless a body has a size that a desktop robot may have, and is near the origin.

    Args:
        points: (k, 3) nodes of its mesh, or corners of its bounding box.
        scale: factor of their coordinates that makes them metres.
        source: how to name the body in an error, e.g. its mesh file.
        fields: what gives the unit and the scale, to be named in an error.
    """
    with np.errstate(over="ignore"):
        points = scale * points
        extent = float(np.ptp(points, axis=0).max())
    if not 1e-3 <= extent <= 10.0:
        likely = [factor for factor in (1e-3, 1e-2, 1e2, 1e3) if 1e-2 <= factor * extent <= 1.0]
        other = [f"; in a unit {f:g} times as large it is {f * extent:g} m" for f in likely]
        what = f"{source}: the body is {extent:g} m long, expected 1 mm to 10 m; check {fields}"
        raise MeshError(what + "".join(other))
    far = float(np.abs(points).max())
    if far > LARGEST_COORDINATE:
        raise MeshError(
            f"{source}: a node lies {far:g} m from the origin, allowed is {LARGEST_COORDINATE:g} m; "
            "move the mesh to the origin"
        )


def checked(nodes: Array, tets: Ints, source: str, overlaps: bool = False) -> TetMesh:
    """The mesh made of these arrays, after every check but that of its size, see `require_size`.

    Args:
        nodes: (n_nodes, 3) positions, in any unit.
        tets: (e, 4) node ids, all of one orientation.
        source: how to name the mesh in an error, e.g. its file.
        overlaps: whether tetrahedra may occupy the same space. The boundary of such a mesh is not closed.

    Raises:
        MeshError: nodes that are not finite or farther apart than numbers reach, inverted or flat tetrahedra,
            tetrahedra that occupy the same space, parts that no face joins.
    """
    if not np.isfinite(nodes).all():
        raise MeshError(
            f"{source}: node {int(np.argwhere(~np.isfinite(nodes))[0, 0])} is not finite; export the mesh "
            "again"
        )
    with np.errstate(over="ignore"):
        extent = float(np.ptp(nodes, axis=0).max())
    if not np.isfinite(extent):
        raise MeshError(f"{source}: the mesh is {extent:g} m long")
    # of a mesh one long, so that the volumes of any unit are numbers
    volumes = signed_volumes(nodes / extent if extent > 0.0 else nodes, tets)
    negative = np.flatnonzero(volumes < 0.0)
    if len(negative) == len(tets):  # the other corner convention, not an error
        return checked(nodes, oriented(nodes, tets), source, overlaps)
    if len(negative):
        raise MeshError(
            f"{source}: {len(negative)} inverted tetrahedra, the first is {negative[0]}"
        )
    flat = np.flatnonzero(~(volumes > 1e-9 * max(volumes.mean(), 1e-12)))
    if len(flat):
        raise MeshError(f"{source}: {len(flat)} flat tetrahedra, the first is {flat[0]}")
    require_apart(tets, source, overlaps)
    require_one_body(nodes, tets, source)
    return TetMesh(nodes, tets, numbers=NodeNumbers(np.arange(len(nodes))))


def require_apart(tets: Ints, source: str, overlaps: bool) -> None:
    """Raise a MeshError where tetrahedra occupy the same space.

    Args:
        tets: (e, 4) node ids, positively oriented.
        source: how to name the mesh in an error.
        overlaps: whether two may lie on the same side of a face; a tetrahedron is never given twice.
    """
    keys = row_keys(np.sort(tets, axis=1))
    _, first, count = np.unique(keys, return_index=True, return_counts=True)
    if count.max() > 1:
        raise MeshError(
            f"{source}: {int((count - 1).sum())} tetrahedra are given more than once, "
            f"for example {first[count > 1].min()}"
        )
    faces = tets[:, FACES].reshape(-1, 3)  # (4 e, 3), seen from outside counter-clockwise
    start = np.argmin(faces, axis=1)
    turned = np.take_along_axis(faces, (start[:, None] + np.arange(3)) % 3, axis=1)
    _, inverse, count = np.unique(row_keys(turned), return_inverse=True, return_counts=True)
    if count.max() > 1:
        double = np.flatnonzero(count[inverse] > 1)  # places of faces, by tetrahedron
        one, other = np.flatnonzero(inverse == inverse[double[0]])[:2] // 4
        involved = len(np.unique(double // 4))
        found = (
            f"{source}: {len(turned) - len(count)} pairs of tetrahedra, for example {one} and {other}, lie "
            f"on the same side of their common face and occupy the same space, {involved} of {len(tets)} "
            f"tetrahedra ({100.0 * involved / len(tets):.3g} %)"
        )
        if not overlaps:
            raise MeshError(
                f"{found}; mesh the volume anew, as `tauten new --repair` does with this file"
            )
        log.warning("%s; what is there counts twice", found)


def part_numbers(tets: Ints) -> Ints:
    """Number of the part that each tetrahedron (e, 4) belongs to, parts being joined by faces: (e,)."""
    faces = np.sort(tets[:, FACES], axis=2).reshape(-1, 3)  # (4 e, 3)
    _, face = np.unique(row_keys(faces), return_inverse=True)
    owner = np.repeat(np.arange(len(tets)), 4)
    incidence = sp.csr_array(
        (np.ones(len(face)), (owner, face)), shape=(len(tets), int(face.max()) + 1)
    )
    _, part = connected_components(incidence @ incidence.T, directed=False)
    numbers: Ints = part.astype(np.int64)
    return numbers


def require_one_body(nodes: Array, tets: Ints, source: str) -> None:
    """Raise a MeshError when the faces that tetrahedra share do not join all of them.

    Args:
        nodes: (n_nodes, 3) positions [m].
        tets: (e, 4) node ids.
        source: how to name the mesh in an error.
    """
    part = part_numbers(tets)
    count, sizes = int(part.max()) + 1, np.bincount(part)
    if count == 1:
        return
    largest = sizes.argmax()
    stray = np.flatnonzero(part != largest)
    others = np.argsort(-sizes, kind="stable")[1 : 1 + SHOWN_BODIES]
    places = ", ".join(
        f"{sizes[i]} around ({', '.join(f'{x:.4g}' for x in nodes[tets[part == i]].mean(axis=(0, 1)))})"
        for i in others
    )
    more = ", ..." if count > 1 + SHOWN_BODIES else ""
    touching = np.isin(tets[stray], tets[part == largest]).any()
    advice = (
        "some share only a node or an edge with the rest: join them by faces"
        if touching
        else "unite them in CAD, or give each a file of its own and name the files in [[bodies]]"
    )
    raise MeshError(
        f"{source}: {count} separate bodies; {len(stray)} tetrahedra beside the largest body's "
        f"{sizes[largest]}: {places}{more} [m]; {advice}"
    )
