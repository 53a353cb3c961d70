"""The map from a robot's coordinates to its nodes, x = T(q), and the products with its derivative.

Nodes are free, move with a frame (`Frames`), or are glued: the weighted mean of four other nodes. A pinned
frame follows such a mean too. The velocities of the nodes that are not fixed are T v with a sparse T = ∂x/∂q
whose pattern never changes and whose entries are numbers or components of levers. Below the rows of the nodes
stand those of the rotations of beam nodes and of drums. Forces on nodes become Tᵀ f, tangents Tᵀ K T,
rows H T.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model.constraints.followers import GluedNodes, follow_matrices, joined_followers
from tauten.model.constraints.frames import Frames, PinnedRegion
from tauten.model.constraints.kernels import transposed_product
from tauten.model.numerics import Array, Bools, Ints, kernel
from tauten.model.points import CsrArrays
from tauten.model.rows import sparse_rows
from tauten.model.system import Pattern

# Entries (row, column, component of the lever, sign) of ∂(ω x a)/∂ω.
CROSS = (
    (0, 1, 2, 1.0),
    (0, 2, 1, -1.0),
    (1, 2, 0, 1.0),
    (1, 0, 2, -1.0),
    (2, 0, 1, 1.0),
    (2, 1, 0, -1.0),
)


@dataclass(frozen=True, slots=True)
class CoordinateMap:
    """T as arrays; made by `make_coordinates`.

    Attributes:
        n: coordinates' velocities, columns of T: three for each free node, six for each rigid region, three
            for each pinned one, one for each drive.
        n_nodes: nodes that are not fixed; T has three rows for each, then three for each node of a beam, then
            one for each drum.
        free: (f,) free nodes, numbered among those that are not fixed.
        indptr: (3 n_nodes + 3 b + d + 1,) CSR row pointers of T.
        indices: (nnz,) its columns.
        factor: (nnz,) and
        source: (nnz,) its values: factor times one (source 0) or times component source − 1 of the levers.
        gather: (3 k, 3 n_nodes) forces on frame nodes and on what follows them, from forces on nodes.
        spread: (3 n_nodes, 3 k) its transpose.
        glue: (3 n_nodes, 3 n_nodes) positions of all nodes from those that glued nodes and pins follow, and
            from the positions of pinned nodes against their pin; None: none is glued or pinned.
        offset: (3 n_nodes,) what fixed nodes contribute to the positions of those that follow them [m].
    """

    n: int
    n_nodes: int
    free: Ints
    indptr: Ints
    indices: Ints
    factor: Array
    source: Ints
    gather: sp.csr_array
    spread: sp.csc_array
    glue: sp.csr_array | None
    offset: Array

    def followed(self, x: Array) -> Array:
        """Positions of all nodes (3 n_nodes,) where glued nodes follow the others in x (3 n_nodes,) [m]."""
        if self.glue is None:
            return x
        positions: Array = self.glue @ x + self.offset
        return positions

    def values(self, levers: Array) -> Array:
        """Values of T (nnz,) for levers (k, 3) [m]."""
        values: Array = self.factor * np.concatenate([[1.0], levers.ravel()])[self.source]
        return values

    def matrix(self, values: Array) -> sp.csr_array:
        """T (3 n_nodes + 3 b + d, n) with these values (nnz,)."""
        rows = len(self.indptr) - 1
        return sp.csr_array((values, self.indices, self.indptr), shape=(rows, self.n))


@dataclass(frozen=True, slots=True)
class NodeMap:
    """The map at one state, a `Through`.

    Attributes:
        coordinates: the map.
        levers: (k, 3) of frame nodes, from `Frames.place` [m].
        T: (nnz,) values of T.
    """

    coordinates: CoordinateMap
    levers: Array
    T: Array

    @property
    def n(self) -> int:
        """Coordinates' velocities."""
        return self.coordinates.n

    def rows(self, H: CsrArrays) -> sp.csr_array:
        """H T (m, n) for rows H (m, 3 n_nodes); entries may occur twice."""
        arrays = mapped_rows(H, self.coordinates.indptr, self.coordinates.indices, self.T)
        return sparse_rows(*arrays, self.n)

    def forces(self, on_nodes: Array) -> Array:
        """Tᵀ f (n,) for forces f on nodes, rotations of beam nodes and drums; the last may be left out."""
        map_ = self.coordinates
        return transposed_product(map_.indptr, map_.indices, self.T, on_nodes, map_.n)


@kernel
def mapped_rows(H: CsrArrays, indptr: Ints, indices: Ints, T: Array) -> CsrArrays:
    """H T, one entry for each product.

    Args:
        H: rows over the nodes.
        indptr: row starts of T.
        indices: columns of T.
        T: values of T.
    """
    data, columns, starts = H
    count = 0
    for e in range(starts[-1]):
        count += indptr[columns[e] + 1] - indptr[columns[e]]
    values, places = np.empty(count), np.empty(count, np.int32)
    begins = np.zeros(starts.shape[0], np.int32)
    at = 0
    for row in range(starts.shape[0] - 1):
        for e in range(starts[row], starts[row + 1]):
            for p in range(indptr[columns[e]], indptr[columns[e] + 1]):
                values[at], places[at] = data[e] * T[p], indices[p]
                at += 1
        begins[row + 1] = at
    return values, places, begins


def make_coordinates(
    frames: Frames,
    pinned: list[PinnedRegion],
    glued: GluedNodes,
    turning: Ints,
    wound: Ints,
    number: Ints,
    x0: Array,
) -> CoordinateMap:
    """The map of a robot.

    Args:
        frames: regions that move with a frame.
        pinned: those of them that are pinned.
        glued: glued nodes.
        turning: (b,) the region whose rotation each node of a beam has, −1 where it is fixed.
        wound: (d,) numbers of drums among the drive regions.
        number: (n_nodes,) number of each node among those that are not fixed, −1 where it is fixed.
        x0: (n_nodes, 3) positions at rest [m].
    """
    m = int(number.max(initial=-1)) + 1
    follows = np.ones(m, dtype=bool)
    follows[frames.nodes] = follows[number[glued.nodes]] = False
    free = np.flatnonzero(follows)
    n = 3 * len(free) + frames.n_velocities
    rows, columns, factors, sources = frame_entries(frames, free)
    followers = joined_followers(pinned, glued)
    masters = number[followers.masters]
    own, every = follow_matrices(
        number[followers.nodes], number[glued.nodes], masters, followers.weights, m
    )
    held = np.where(masters < 0, followers.weights, 0.0)
    shift = np.zeros((m, 3))
    np.add.at(shift, number[followers.nodes], np.einsum("ga,gai->gi", held, x0[followers.masters]))
    # a row of a follower has the entries of its masters, times their weights
    by_node = sp.csr_array(
        (np.arange(1, len(rows) + 1), (rows, np.arange(len(rows)))), shape=(3 * m, len(rows))
    )
    spread = sp.csr_array(sp.kron(own, np.eye(3), format="csr"))
    product = sp.coo_array(spread @ (by_node > 0).astype(float))
    entry = product.col
    order = np.lexsort((columns[entry], product.row))
    row = product.row[order]
    entry, weight = entry[order], product.data[order]
    spins, spin_factors, present = rotation_entries(frames, turning)
    spins = np.concatenate([spins, frames.drives[wound]])
    spin_factors = np.append(spin_factors, np.ones(len(wound)))
    turned = np.repeat(present.astype(np.int64), 3)
    counts = [np.bincount(row, minlength=3 * m), turned, np.ones(len(wound), np.int64)]
    indptr = np.concatenate([[0], np.cumsum(np.concatenate(counts))])
    picked = (3 * frames.nodes[:, None] + np.arange(3)).ravel()
    gather = sp.csr_array(sp.csr_array(spread.T)[picked])
    return CoordinateMap(
        n=n,
        n_nodes=m,
        free=free,
        indptr=indptr.astype(np.int64),
        indices=np.concatenate([columns[entry], 3 * len(free) + spins]).astype(np.int64),
        factor=np.concatenate([weight * factors[entry], spin_factors]),
        source=np.concatenate([sources[entry], np.zeros(len(spins))]).astype(np.int64),
        gather=gather,
        spread=gather.T,
        glue=spread if len(followers.nodes) else None,
        offset=np.asarray(every @ shift).ravel(),
    )


def frame_entries(frames: Frames, free: Ints) -> tuple[Ints, Ints, Array, Ints]:
    """Rows, columns, factors and sources (e,) of T for frames and free nodes (f,), not for followers."""
    c, f = np.arange(3), len(free)
    rows = [(3 * free[:, None] + c).ravel()]
    columns, factors, sources = [np.arange(3 * f)], [np.ones(3 * f)], [np.zeros(3 * f, np.int64)]
    rotations, drives = 3 * f + frames.rotations, 3 * f + frames.drives
    for place, (node, owner) in enumerate(zip(frames.nodes, frames.owner, strict=True)):
        if owner < frames.n_rigid:
            rows.append(3 * node + c)
            columns.append(3 * f + 6 * owner + c)
            factors.append(np.ones(3))
            sources.append(np.zeros(3, np.int64))
        if owner < frames.n_turning:
            i, j, component, sign = (np.array(part) for part in zip(*CROSS, strict=True))
            rows.append(3 * node + i)
            columns.append(rotations[owner] + j)
            factors.append(sign)
            sources.append(1 + 3 * place + component)
        else:
            rows.append(3 * node + c)
            columns.append(np.full(3, drives[owner - frames.n_turning]))
            factors.append(np.ones(3))
            sources.append(1 + 3 * place + c)
    parts = (rows, columns, factors, sources)
    rows_, columns_, factors_, sources_ = (np.concatenate(part) for part in parts)
    return rows_, columns_, factors_, sources_


def rotation_entries(frames: Frames, turning: Ints) -> tuple[Ints, Array, Bools]:
    """Columns and factors of the rows of T for rotations, `turning` (b,), and which nodes have rows.

    Returns:
        Columns (3 p,) among the velocities of the frames, factors (3 p,), and (b,) bool of which p are true.
    """
    drive = turning - frames.n_turning
    by_frame = (turning >= 0) & (drive < 0)
    by_drive = drive >= 0
    by_drive[by_drive] = frames.turns[drive[by_drive]]
    columns, factors = np.zeros((len(turning), 3), np.int64), np.ones((len(turning), 3))
    columns[by_frame] = frames.rotations[turning[by_frame]][:, None] + np.arange(3)
    columns[by_drive] = frames.drives[drive[by_drive]][:, None]
    factors[by_drive] = frames.axes[drive[by_drive]]
    present = by_frame | by_drive
    return columns[present].ravel(), factors[present].ravel(), present


@dataclass(frozen=True, slots=True)
class Congruence:
    """Where the entries of a sparse K go in Tᵀ K T; made by `make_congruences`.

    Attributes:
        copied: (c, 2) places of entries between free nodes, in K and in the product.
        products: (p, 4) place in K, in the values of T for the row and for the column, and in the product.
    """

    copied: Ints
    products: Ints

    def apply(self, K: Array, T: Array, size: int) -> Array:
        """Values (size,) of Tᵀ K T.

        Args:
            K: (nnz,) values of K.
            T: values of T.
            size: entries in the pattern of the product.
        """
        result = np.zeros(size)
        add_congruence(K, T, self.copied, self.products, result)
        return result


@kernel
def add_congruence(K: Array, T: Array, copied: Ints, products: Ints, result: Array) -> None:
    """Add Tᵀ K T to `result`; arguments as in `Congruence`.

    Args:
        K: (nnz,) values of K.
        T: values of T.
        copied: (c, 2) places.
        products: (p, 4) places.
        result: (size,) values of the product, accumulated.
    """
    for k in range(copied.shape[0]):
        result[copied[k, 1]] += K[copied[k, 0]]
    for p in range(products.shape[0]):
        value = T[products[p, 1]] * K[products[p, 0]] * T[products[p, 2]]
        result[products[p, 3]] += value


@dataclass(frozen=True, slots=True)
class ProductPattern:
    """The pattern of a constrained robot and how the matrices of its nodes enter it.

    Attributes:
        pattern: of Tᵀ K T; its `dof` is that of no node and empty.
        tangent: how a tangent of the nodes enters.
        inertia: how lumped masses of the nodes' degrees of freedom, then of beam nodes' rotations, enter.
        joints: how the entries of beams and hinges enter.
        rigid_places: (n_turning, 3, 3) places of the blocks of rotations.
        drive_places: (n_drives,) places of the diagonal of drives.
    """

    pattern: Pattern
    tangent: Congruence
    inertia: Congruence
    joints: Congruence
    rigid_places: Ints
    drive_places: Ints


def make_product_pattern(
    coordinates: CoordinateMap, raw: Pattern, frames: Frames, joints: tuple[Ints, Ints]
) -> ProductPattern:
    """The pattern of Tᵀ K T for K in the pattern of the nodes.

    Args:
        coordinates: T.
        raw: pattern over the degrees of freedom of all nodes that are not fixed.
        frames: regions that move with a frame.
        joints: rows and columns (e,) in K of the entries of beams and hinges, −1 where they are left out.
    """
    n, first = coordinates.n, 3 * len(coordinates.free)
    columns = np.repeat(np.arange(raw.n), np.diff(raw.indptr))
    diagonal = np.arange(len(coordinates.indptr) - 1)
    parts = (raw.indices, columns), (diagonal, diagonal), joints
    tangent, inertia, joined = (expanded(coordinates, i, j) for i, j in parts)
    three = np.arange(3)
    rotations = first + frames.rotations[:, None, None]
    turns = (rotations + three) * n + rotations + three[:, None]  # column times n plus row
    keys = [one[3] for one in (tangent, inertia, joined)]
    pattern = np.unique(np.concatenate([*keys, np.arange(n) * (n + 1), turns.ravel()]))
    column = pattern // n
    indptr = np.concatenate([[0], np.cumsum(np.bincount(column, minlength=n))])

    def placed(parts: tuple[Ints, Ints, Ints, Ints]) -> Congruence:
        source, left, right, key = parts
        place = np.searchsorted(pattern, key)
        alone = np.diff(coordinates.indptr)
        owner = np.repeat(np.arange(len(alone)), alone)  # row of each entry of T
        plain = (coordinates.source == 0) & (coordinates.factor == 1.0) & (alone[owner] == 1)
        direct = plain[left] & plain[right]
        others = np.stack([source, left, right, place], axis=1)[~direct]
        return Congruence(
            np.stack([source[direct], place[direct]], axis=1),
            others[np.argsort(others[:, 3], kind="stable")],
        )

    return ProductPattern(
        Pattern(
            dof=np.zeros(0, dtype=np.int64),
            indptr=indptr.astype(np.int64),
            indices=(pattern % n).astype(np.int64),
            diagonal=np.searchsorted(pattern, np.arange(n) * (n + 1)),
        ),
        placed(tangent),
        placed(inertia),
        placed(joined),
        np.searchsorted(pattern, turns),
        np.searchsorted(pattern, (first + frames.drives) * (n + 1)),
    )


def expanded(coordinates: CoordinateMap, i: Ints, j: Ints) -> tuple[Ints, Ints, Ints, Ints]:
    """Every product that entries (i, j) of K have in Tᵀ K T, four arrays (p,).

    Args:
        coordinates: T.
        i: (nnz,) rows of K, −1 where an entry is left out.
        j: (nnz,) columns of K.

    Returns:
        Place in K, places in T of the row's and of the column's entry, and column · n + row in the product.
    """
    count = np.append(np.diff(coordinates.indptr), 0)
    many = np.where(j < 0, 0, count[i] * count[j])
    source = np.repeat(np.arange(len(i)), many)
    local = np.arange(len(source)) - np.repeat(np.cumsum(many) - many, many)
    width = count[j][source]
    left = coordinates.indptr[i][source] + local // np.maximum(width, 1)
    right = coordinates.indptr[j][source] + local % np.maximum(width, 1)
    key = coordinates.indices[right] * coordinates.n + coordinates.indices[left]
    return source, left, right, key
