"""Keys of rows give what numpy finds by comparing the rows."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.model.numerics import row_keys


@pytest.mark.parametrize(
    "largest", [3, 10**6, 2**50]
)  # the last is beyond a product of two columns
def test_the_same_rows_are_found_in_the_same_order(largest: int) -> None:
    rng = np.random.default_rng(0)
    rows = rng.choice(rng.integers(0, largest, size=4, endpoint=True), size=(200, 3))
    unique, first, inverse, count = np.unique(
        rows, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    _, *found = np.unique(
        row_keys(rows), return_index=True, return_inverse=True, return_counts=True
    )
    for own, numpys in zip(found, (first, inverse.ravel(), count), strict=True):
        np.testing.assert_array_equal(own, numpys)
    np.testing.assert_array_equal(rows[found[0]], unique)


def test_no_rows_have_no_keys() -> None:
    assert row_keys(np.zeros((0, 3), dtype=np.int64)).shape == (0,)
