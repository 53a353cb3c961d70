"""Triangles that cross: the tree finds what comparing all pairs finds, also in surfaces of many triangles."""

from __future__ import annotations

import itertools
import time

import numpy as np
import pytest

from tauten.model.numerics import Array, Ints
from tauten.service.new.crossing import first_crossing, pierced


def sphere(rings: int) -> tuple[Array, Ints]:
    """Vertices and triangles of a tube around a sphere without its poles."""
    polar = np.linspace(0.0, np.pi, rings + 2)[1:-1, None]
    around = np.linspace(0.0, 2.0 * np.pi, 2 * rings, endpoint=False)[None]
    x, y = np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around)
    vertices = np.stack([x, y, np.broadcast_to(np.cos(polar), x.shape)], axis=2).reshape(-1, 3)
    ids = np.arange(len(vertices)).reshape(x.shape)
    a, b = ids[:-1], np.roll(ids, -1, axis=1)[:-1]
    c, d = ids[1:], np.roll(ids, -1, axis=1)[1:]
    corners = [np.stack(part, axis=2).reshape(-1, 3) for part in ((a, c, b), (b, c, d))]
    return vertices, np.concatenate(corners)


def all_crossings(vertices: Array, triangles: Ints) -> set[tuple[int, int]]:
    """Every pair that crosses, by comparing all of them."""
    pairs = np.array(list(itertools.combinations(range(len(triangles)), 2)))
    shared = (triangles[pairs[:, 0], :, None] == triangles[pairs[:, 1], None, :]).any(axis=(1, 2))
    pairs = pairs[~shared]
    a, b = vertices[triangles[pairs[:, 0]]], vertices[triangles[pairs[:, 1]]]
    return {(int(i), int(j)) for i, j in pairs[pierced(a, b) | pierced(b, a)]}


def test_the_tree_finds_what_all_pairs_show() -> None:
    """Random triangles of very different sizes, also in one plane and on one line; fixed seed."""
    rng = np.random.default_rng(5)
    crossed = 0
    for case in range(60):
        count = int(rng.integers(1, 40))
        size = 10.0 ** rng.uniform(-2.0, 0.3, size=(count, 1, 1))
        corners = rng.uniform(size=(count, 1, 3)) + size * rng.normal(size=(count, 3, 3))
        corners[..., : case % 3] = 0.5
        vertices, triangles = corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)
        if count > 3:
            triangles[: count // 2, 0] = triangles[0, 0]  # many share a vertex
        expected = all_crossings(vertices, triangles) if count > 1 else set()
        found = first_crossing(vertices, triangles)
        assert (found is None) == (not expected), f"case {case}"
        assert found is None or tuple(sorted(found)) in expected
        crossed += found is not None
    assert 10 < crossed < 50


def test_a_surface_of_many_triangles_takes_seconds_and_reports_its_progress() -> None:
    """The loop over triangles that this replaces took 28 s of processor for these."""
    vertices, triangles = sphere(72)
    assert len(triangles) > 20_000
    assert first_crossing(*sphere(2)) is None  # compiles what it needs
    shares: list[float] = []
    before = time.process_time()
    assert first_crossing(vertices, triangles, lambda share, what: shares.append(share)) is None
    assert time.process_time() - before < 10.0
    assert sum(shares) == pytest.approx(1.0, abs=1e-9)
    assert len(shares) > 5
    two = np.vstack([vertices, 0.5 * vertices + [0.9, 0.0, 0.0]])
    found = first_crossing(two, np.vstack([triangles, triangles + len(vertices)]))
    assert found is not None
    assert {index < len(triangles) for index in found} == {True, False}
