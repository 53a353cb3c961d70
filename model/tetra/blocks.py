"""The 3x3 blocks of a symmetric tangent, each stored once while elements are summed.

An element adds to the blocks (b, a) of its nodes a ≤ b, so that only the lower triangle is summed; `add_to`
then writes every block and its transpose to the CSC values of the whole matrix. Block m stands in row m of an
array (m, 9), column by column: entry 3 j + i is that of row i and column j.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Ints, kernel
from tauten.model.system import Pattern


@dataclass(frozen=True, slots=True)
class LowerBlocks:
    """Where blocks stand in the CSC values of a matrix.

    Attributes:
        place: (m, 2) of the first entry of each block, and of its transpose.
        length: (m, 2) entries in each column of the node of the block's columns, and of its rows.
        nonzeros: values of the matrix.
    """

    place: Ints
    length: Ints
    nonzeros: int

    def zeros(self) -> Array:
        """Blocks (m, 9) to sum elements into."""
        return np.zeros((len(self.place), 9))

    def add_to(self, K: Array, blocks: Array) -> None:
        """Add blocks (m, 9) and their transposes to the CSC values K (nnz,)."""
        _add_blocks(blocks, self.place, self.length, K)


def lower_blocks(pattern: Pattern, groups: list[Ints]) -> tuple[LowerBlocks, tuple[Ints, ...]]:
    """The blocks of a pattern that couple nodes of elements, of groups (g, s) that ascend in each row.

    Returns:
        The blocks, and for each array the number of the block of every pair a ≤ b of its nodes, in the order
        (0, 0), (0, 1), … (s − 1, s − 1): (g, s (s + 1) / 2), −1 where a node is fixed.
    """
    places, lengths, shapes = [np.zeros((0, 2), np.int64)], [np.zeros((0, 2), np.int64)], []
    for nodes in groups:
        slot, column = pattern.blocks(nodes)
        a, b = np.triu_indices(nodes.shape[1])
        places.append(np.stack([slot[:, b, a], slot[:, a, b]], axis=2).reshape(-1, 2))
        lengths.append(np.stack([column[:, a], column[:, b]], axis=2).reshape(-1, 2))
        shapes.append((len(nodes), len(a)))
    place, length = np.concatenate(places), np.concatenate(lengths)
    first, index, number = np.unique(place[:, 0], return_index=True, return_inverse=True)
    fixed = int((first < 0).any())  # the first one stands for all pairs with a fixed node
    numbers = np.split(number - fixed, np.cumsum([g * p for g, p in shapes]))[:-1]
    blocks = LowerBlocks(
        np.ascontiguousarray(place[index[fixed:]]),
        np.ascontiguousarray(length[index[fixed:]]),
        len(pattern.indices),
    )
    return blocks, tuple(part.reshape(shape) for part, shape in zip(numbers, shapes, strict=True))


@kernel
def _add_blocks(blocks: Array, place: Ints, length: Ints, K: Array) -> None:
    """`LowerBlocks.add_to`."""
    for m in range(blocks.shape[0]):
        for j in range(3):
            for i in range(3):
                K[place[m, 0] + j * length[m, 0] + i] += blocks[m, 3 * j + i]
        if place[m, 0] != place[m, 1]:
            for j in range(3):
                for i in range(3):
                    K[place[m, 1] + i * length[m, 1] + j] += blocks[m, 3 * j + i]
