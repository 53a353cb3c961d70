"""Candidates that are treated together."""

from __future__ import annotations

import numpy as np

from tauten.model.contact import BLOCK, blocks_of


def test_blocks_end_with_parts_of_a_surface_and_with_pairs() -> None:
    """Two patches of 50 candidates, one of two candidates, and a pair with more than a block."""
    patches = [np.tile([3 * i, 3 * i + 1, 3 * i + 2], (n, 1)) for i, n in enumerate((50, 50, 2))]
    many = np.tile([9, 10, 11], (BLOCK + 5, 1))
    found = blocks_of([np.concatenate(patches), many], 12)
    expected = [
        (0, 50, 0),
        (50, 100, 0),
        (100, 102, 0),
        (102, 102 + BLOCK, 1),
        (102 + BLOCK, 107 + BLOCK, 1),
    ]
    assert found.tolist() == [list(block) for block in expected]


def test_small_parts_share_a_block() -> None:
    nodes = np.arange(60).reshape(20, 3)  # twenty triangles apart from each other
    assert blocks_of([nodes], 60).tolist() == [[0, 16, 0], [16, 20, 0]]


def test_no_pairs_have_no_blocks() -> None:
    assert blocks_of([], 5).shape == (0, 3)
