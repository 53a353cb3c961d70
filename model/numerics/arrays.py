"""Names for the array types that signatures use, integers for the rows of a table, records of arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

Array: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Bools: TypeAlias = NDArray[np.bool_]

T = TypeVar("T")

PAIRS = 10**7  # whose distances are computed at once


def joined(parts: Sequence[T]) -> T:
    """Records of one type, at least one, made from arrays and tuples, as one record of longer ones."""
    kind: Any = type(parts[0])
    names = [field.name for field in fields(kind) if field.init]
    columns = [[getattr(part, name) for part in parts] for name in names]
    longer = (sum(one, ()) if isinstance(one[0], tuple) else np.concatenate(one) for one in columns)
    return cast(T, kind(*longer))


def row_keys(rows: Ints) -> Ints:
    """Integers (r,) that compare as the rows do from left to right: equal, smaller or larger.

    `np.unique` of them finds the same rows in the same order as with `axis=0`, several times as fast. Rows
    (r, c) are of non-negative integers below 2⁶³ / r, such as the nodes of faces.
    """
    keys = np.zeros(len(rows), dtype=np.int64)
    for column in rows.T:
        size = int(column.max(initial=0)) + 1
        if int(keys.max(initial=0)) >= np.iinfo(np.int64).max // size - 1:
            keys = np.unique(keys, return_inverse=True)[1]  # the rank is as good, and smaller
        keys = keys * size + column
    return keys


def longest(vectors: Array) -> float:
    """Length of the longest of some vectors (m, 3) or (3 m,); 0: there is none.

    Not their largest component, which depends on how the axes lie.
    """
    lengths = np.hypot.reduce(vectors.reshape(-1, 3), axis=1)  # (m,), also where squares overflow
    return float(np.maximum.reduce(lengths, initial=0.0))


def diameter(points: Array) -> float:
    """Largest distance between two of some points (m, 3); 0: there are none, or one is not finite.

    Not the diagonal of their bounding box, which depends on how the axes lie.
    """
    if len(points) == 0:
        return 0.0
    with np.errstate(over="ignore", invalid="ignore"):  # meshes are checked after they are made
        away = np.linalg.norm(points - points.mean(axis=0), axis=1)  # (m,)
        largest, one = 0.0, int(away.argmax())
        while (reach := np.linalg.norm(points - points[one], axis=1)).max() > largest:
            largest, one = float(reach.max()), int(reach.argmax())
        outer = points[away + away.max() > largest]  # no other is an end of a longer distance
    for some in np.array_split(outer, len(outer) ** 2 // PAIRS + 1):
        largest = max(largest, float(cdist(some, outer).max(initial=0.0)))
    return largest


def positive_part(blocks: Array) -> Array:
    """The nearest positive semidefinite matrices (m, k, k) to symmetric ones; what is not finite is kept."""
    if not np.isfinite(blocks).all():
        return blocks
    values, vectors = np.linalg.eigh(blocks)
    part: Array = (vectors * np.maximum(values, 0.0)[:, None]) @ vectors.swapaxes(1, 2)
    return part
