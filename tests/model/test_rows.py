"""Rows with a sparse Jacobian, and such whose Jacobian is a product."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from tauten.model import ChainedRows, Rows
from tauten.model.rows import sparse_rows, stack


def some_rows(m: int, seed: int) -> tuple[sp.csr_array, Rows]:
    """Sparse rows (m, 30) of scipy, and the same as rows made without it."""
    rng = np.random.default_rng(seed)
    H, delta = sp.random_array((m, 30), density=0.2, format="csr", rng=rng), rng.normal(size=m)
    starts, columns = H.indptr.astype(np.int64), H.indices.astype(np.int64)
    return H, Rows(sparse_rows(H.data, columns, starts, 30), delta)


def test_sparse_rows_are_those_of_scipy() -> None:
    H, rows = some_rows(7, 0)
    lam, v, order = np.arange(1.0, 8.0), np.linspace(-1.0, 2.0, 30), np.array([6, 0, 3, 3])
    assert (rows.H.shape, rows.H.nnz, len(rows), rows.n) == (H.shape, H.nnz, 7, 30)
    assert rows.H.indices.dtype == rows.H.indptr.dtype == np.int32
    for found, known in (
        (rows.dense(), H.toarray()),
        (rows.H.T.toarray(), H.toarray().T),
        (rows.H @ v, H @ v),
        (rows.weighed(lam), H.T @ lam),
        (rows.in_order(order).dense(), H[order].toarray()),
        (rows.in_order(order).delta, rows.delta[order]),
    ):
        np.testing.assert_array_equal(found, known)


def test_rows_below_each_other_are_those_of_scipy() -> None:
    (H, one), (G, other) = some_rows(7, 0), some_rows(3, 1)
    both = stack([one, other])
    np.testing.assert_array_equal(both.dense(), sp.vstack([H, G]).toarray())
    np.testing.assert_array_equal(both.delta, np.concatenate([one.delta, other.delta]))


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
