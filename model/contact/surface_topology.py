"""Target surfaces of all contact pairs in flat arrays, with the adjacency that the kernels need."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from tauten.model.numerics import Ints


class SurfaceTopology(NamedTuple):
    """Triangles of several surfaces, one after the other, with their adjacency inside each surface.

    A named tuple, because numba kernels take these as arguments.

    Attributes:
        triangles: (t, 3) vertex ids.
        first: (p + 1,) where each surface's triangles start.
        opposite: (t, 3) vertex opposite edge k in the triangle on the other side of it, −1 on the border:
            where there is not exactly one such triangle.
        neighbour: (t, 3) that triangle, −1 on the border.
        fan_first: (t, 3) where the fan of corner k starts in `fans`, −1 for corners on the border.
        fan_last: (t, 3) where it ends.
        fans: triangles around each inner vertex.
        adjacent_first: (t + 1,) where the candidates adjacent to each triangle start in `adjacent`.
        adjacent: candidates that are not compared with the target triangle: their own triangle shares a
            vertex with it, or they were given as such.
    """

    triangles: Ints
    first: Ints
    opposite: Ints
    neighbour: Ints
    fan_first: Ints
    fan_last: Ints
    fans: Ints
    adjacent_first: Ints
    adjacent: Ints


def join_surfaces(
    surfaces: list[Ints], candidates: list[Ints], apart: list[Ints], names: list[str]
) -> SurfaceTopology:
    """The topology of the target surfaces of all contact pairs.

    Args:
        surfaces: target of each pair, (t, 3) vertex ids.
        candidates: of each pair, (m, 3) vertex ids of the triangles that its candidates lie in.
        apart: of each pair, (k, 2) candidate and triangle that are not compared.
        names: of the pairs, for errors.

    Raises:
        ValueError: neighbouring triangles of a surface run round in opposite senses.
    """
    none = np.zeros((0, 3), dtype=np.int64)
    surfaces, names = [*surfaces, none], [*names, ""]  # arrays keep their shape without surfaces
    parts = [neighbours(triangles, name) for triangles, name in zip(surfaces, names, strict=True)]
    fan_parts = [fans(t, neighbour) for t, (_, neighbour) in zip(surfaces, parts, strict=True)]
    first = np.cumsum([0, *(len(triangles) for triangles in surfaces)])
    adjacent_first, adjacent = adjacent_candidates(surfaces[:-1], candidates, apart)
    fan_base = np.cumsum([0, *(len(members) for _, _, members in fan_parts)])

    def joined(arrays: list[Ints], base: Ints | None = None) -> Ints:
        shift = np.zeros(len(arrays), dtype=np.int64) if base is None else base[:-1]
        moved = [np.where(a < 0, a, a + b) for a, b in zip(arrays, shift, strict=True)]
        return np.concatenate(moved)

    return SurfaceTopology(
        triangles=joined(surfaces),
        first=first[:-1],
        opposite=joined([opposite for opposite, _ in parts]),
        neighbour=joined([neighbour for _, neighbour in parts], first),
        fan_first=joined([begin for begin, _, _ in fan_parts], fan_base),
        fan_last=joined([end for _, end, _ in fan_parts], fan_base),
        fans=joined([members for _, _, members in fan_parts], first),
        adjacent_first=adjacent_first,
        adjacent=adjacent,
    )


def adjacent_candidates(
    surfaces: list[Ints], candidates: list[Ints], apart: list[Ints]
) -> tuple[Ints, Ints]:
    """`adjacent_first` (t + 1,) and `adjacent` of `SurfaceTopology`.

    Args:
        surfaces: target of each pair, (t, 3) vertex ids.
        candidates: of each pair, (m, 3) vertex ids of the triangles that its candidates lie in.
        apart: of each pair, (k, 2) candidate and triangle that are not compared.
    """
    counts, members, base = [np.zeros(1, dtype=np.int64)], [np.zeros(0, dtype=np.int64)], 0
    for triangles, nodes, pairs in zip(surfaces, candidates, apart, strict=True):
        if len(triangles) == 0:  # a shape instead
            base += len(nodes)
            continue
        vertices = 1 + max(triangles.max(), nodes.max())
        shared = sp.csr_array(incidence(triangles, vertices) @ incidence(nodes, vertices).T)
        given = (np.ones(len(pairs)), (pairs[:, 1], pairs[:, 0]))
        shared = sp.csr_array(shared + sp.csr_array(given, shape=shared.shape))
        shared.sort_indices()
        counts.append(np.diff(shared.indptr))
        members.append(base + shared.indices)
        base += len(nodes)
    first = np.cumsum(np.concatenate(counts)).astype(np.int64)
    return first, np.concatenate(members).astype(np.int64)


def incidence(triangles: Ints, vertices: int) -> sp.csr_array:
    """Which vertices each triangle has: (t, v)."""
    ones, rows = np.ones(triangles.size), np.repeat(np.arange(len(triangles)), 3)
    return sp.csr_array((ones, (rows, triangles.ravel())), shape=(len(triangles), vertices))


def neighbours(triangles: Ints, name: str) -> tuple[Ints, Ints]:
    """`opposite` and `neighbour` of `SurfaceTopology`, both (t, 3), for one surface.

    An edge with more than two triangles counts as border, because the side of a point near it is undefined.
    """
    edges = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)  # (3 t, 2)
    _, number, count = np.unique(
        np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    order = np.argsort(number.ravel(), kind="stable")
    starts = np.cumsum(count) - count
    one = order[starts[count == 2]]  # half-edges in pairs
    other = order[starts[count == 2] + 1]
    wrong = np.flatnonzero(edges[one, 0] == edges[other, 0])
    if len(wrong):
        raise ValueError(
            f"{name}: triangles {one[wrong[0]] // 3} and {other[wrong[0]] // 3} are not oriented "
            "alike, all must be counter-clockwise seen from outside"
        )
    opposite = np.full(len(edges), -1, dtype=np.int64)
    neighbour = np.full(len(edges), -1, dtype=np.int64)
    for edge, twin in ((one, other), (other, one)):
        neighbour[edge] = twin // 3
        opposite[edge] = triangles[twin // 3, (twin % 3 + 2) % 3]
    return opposite.reshape(-1, 3), neighbour.reshape(-1, 3)


def fans(triangles: Ints, neighbour: Ints) -> tuple[Ints, Ints, Ints]:
    """Where each corner's fan starts and ends (t, 3), and the triangles of all fans.

    Corners on the border have no fan: −1.
    """
    vertices, local = np.unique(triangles, return_inverse=True)
    local = local.reshape(-1, 3)
    border = np.zeros(len(vertices), dtype=bool)
    for k in range(3):
        free_edge = neighbour[:, k] < 0
        border[local[free_edge, k]] = True
        border[local[free_edge, (k + 1) % 3]] = True
    order = np.argsort(local.ravel(), kind="stable")
    end = np.cumsum(np.bincount(local.ravel(), minlength=len(vertices)))
    begin = np.concatenate([[0], end[:-1]]).astype(np.int64)
    return (
        np.where(border[local], -1, begin[local]),
        np.where(border[local], -1, end[local]),
        order // 3,
    )
