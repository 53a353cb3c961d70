"""What a mesh file calls its parts: groups of cells (physical groups, sets, values), and numbers of nodes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tauten.model.numerics import Array, Bools, Ints

MOST_VALUES = 256  # of an array of integers; one with more numbers its cells and names no groups


@dataclass(frozen=True, slots=True)
class CellGroup:
    """Cells of a mesh under a name.

    Attributes:
        name: as in the mesh file; "ARRAY:VALUE" where an array of integers gives it.
        tets: (k,) tetrahedra.
        triangles: (t, 3) triangles, as node ids.
    """

    name: str
    tets: Ints
    triangles: Ints


def read_groups(raw: Any, kind: str, used: Ints) -> tuple[CellGroup, ...]:
    """The groups of a `meshio.Mesh`, without empty ones.

    Args:
        raw: the mesh.
        kind: of its tetrahedra, in the words of meshio.
        used: (n_nodes,) ascending ids of the nodes that are kept, in the file's numbers.
    """
    masks: dict[str, list[Bools]] = {}
    sizes = [len(block.data) for block in raw.cells]
    for name, blocks in (raw.cell_sets or {}).items():
        if not name.startswith("gmsh:"):
            masks[name] = [members(part, size) for part, size in zip(blocks, sizes, strict=False)]
    by_tag = {(int(tag), int(dim)): name for name, (tag, dim) in tags_of(raw).items()}
    for name, blocks in raw.cell_data.items():
        arrays = [np.asarray(block) for block in blocks]
        if any(array.dtype.kind not in "iu" or array.ndim != 1 for array in arrays):
            continue
        values = np.unique(np.concatenate(arrays))
        for value in values if len(values) <= MOST_VALUES else []:
            found = [array == value for array in arrays]
            masks[f"{name}:{value}"] = found
            if name == "gmsh:physical":
                for dim in (2, 3):
                    cells = [
                        mask if block.dim == dim else np.zeros_like(mask)
                        for mask, block in zip(found, raw.cells, strict=True)
                    ]
                    if (int(value), dim) in by_tag:
                        masks.setdefault(by_tag[int(value), dim], cells)
    groups = (group_of(name, mask, raw, kind, used) for name, mask in masks.items())
    return tuple(group for group in groups if len(group.tets) or len(group.triangles))


def tags_of(raw: Any) -> dict[str, Array]:
    """Physical groups of a `meshio.Mesh`: tag and dimension by name."""
    return {name: data for name, data in raw.field_data.items() if np.shape(data) == (2,)}


def members(part: Any, size: int) -> Bools:
    """Which of `size` cells a set of one block holds: (size,) bool."""
    chosen = np.zeros(size, dtype=bool)
    if part is not None:
        chosen[np.asarray(part, dtype=np.int64)] = True
    return chosen


def group_of(name: str, masks: list[Bools], raw: Any, kind: str, used: Ints) -> CellGroup:
    """One group.

    Args:
        name: its name.
        masks: which cells of each block are in it.
        raw: a `meshio.Mesh`.
        kind: of its tetrahedra.
        used: (n_nodes,) ascending ids of the nodes that are kept.
    """
    tets, triangles, first = [np.zeros(0, np.int64)], [np.zeros((0, 3), np.int64)], 0
    for block, mask in zip(raw.cells, masks, strict=False):
        if block.type == kind:
            tets.append(first + np.flatnonzero(mask))
            first += len(block.data)
        elif block.type in ("triangle", "triangle6"):
            corners = np.asarray(block.data)[mask, :3].astype(np.int64)
            corners = corners[np.isin(corners, used).all(axis=1)]
            triangles.append(np.searchsorted(used, corners).reshape(-1, 3))
    return CellGroup(name, np.concatenate(tets), np.concatenate(triangles))


def divided(group: CellGroup, edges: Ints, middle: Ints) -> CellGroup:
    """The group after every tetrahedron was cut into eight and every triangle into four.

    Args:
        group: before.
        edges: (k, 2) edges of the mesh with ascending node ids.
        middle: (k,) the node in the middle of each.
    """
    size = int(edges.max(initial=0)) + 1
    keys = edges[:, 0] * size + edges[:, 1]
    order = np.argsort(keys)

    def between(triangles: Ints, first: int, second: int) -> Ints:
        pair = np.sort(triangles[:, [first, second]], axis=1)
        places = np.searchsorted(keys, pair[:, 0] * size + pair[:, 1], sorter=order)
        return np.asarray(middle[order[places]])

    known = np.isin(np.sort(group.triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2) @ [size, 1], keys)
    triangles = group.triangles[known.all(axis=1)]  # without those that are no faces of the mesh
    a, b, c = triangles.T
    ab, bc, ca = (between(triangles, *pair) for pair in ((0, 1), (1, 2), (2, 0)))
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    smaller = np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 3)
    return CellGroup(group.name, (8 * group.tets[:, None] + np.arange(8)).ravel(), smaller)


@dataclass(frozen=True, slots=True)
class NodeNumbers:
    """The numbers of nodes in a mesh file, counted from 0.

    Attributes:
        of_file: (m,) numbers of the first m nodes in the file, ascending; it may have nodes that no
            tetrahedron uses.
        middles: nodes added after these, level by level: the two ends (k, 2) that each lies between.
    """

    of_file: Ints
    middles: tuple[Ints, ...] = ()

    def chosen(self, wanted: Ints) -> Bools:
        """The nodes with some numbers, and those added between two of them: (n_nodes,) bool.

        Raises:
            ValueError: a number that no node has.
        """
        missing = np.setdiff1d(wanted, self.of_file)
        if len(missing):
            raise ValueError(
                f"node {missing[0]} is not in the mesh or in no tetrahedron; numbers count from 0 and go up "
                f"to {self.of_file[-1]}"
            )
        found: Bools = np.isin(self.of_file, wanted)
        for ends in self.middles:
            found = np.concatenate([found, found[ends].all(axis=1)])
        return found

    def with_middles(self, ends: Ints) -> NodeNumbers:
        """These nodes with one more between each two `ends` (k, 2)."""
        return replace(self, middles=(*self.middles, ends))
