"""Rows whose Jacobian is a product."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from tauten.model import ChainedRows, Rows


def test_a_product_is_the_same_as_its_dense_rows() -> None:
    rng = np.random.default_rng(0)
    S = sp.random_array((7, 30), density=0.2, format="csr", rng=rng)
    J, delta, v = rng.normal(size=(30, 4)), rng.normal(size=7), rng.normal(size=4)
    starts, columns = S.indptr.astype(np.int32), S.indices.astype(np.int32)
    found, known = ChainedRows(starts, columns, S.data, J, delta), Rows(S @ J, delta)
    assert (len(found), found.n) == (len(known), known.n) == (7, 4)
    chosen = np.array([5, 0, 5])
    np.testing.assert_allclose(found.dense(), known.dense(), atol=1e-14)
    np.testing.assert_allclose(found.chosen(chosen), known.chosen(chosen), atol=1e-14)
    np.testing.assert_allclose(found.after(0.02, v), known.after(0.02, v), atol=1e-14)
