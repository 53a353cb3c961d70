"""The gap against signed distances computed another way, and its gradient against differences."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauten.model.contact import ContactPair, ContactSet, contact_rows
from tauten.model.mesh import boundary_triangles
from tauten.model.numerics import Array, Ints
from tauten.model.points import NodeMotion, Placed, points_at

ALARM = 0.4


def placed_nodes(x: Array, dof: Ints, n: int) -> Placed:
    """The nodes themselves at one state."""
    return NodeMotion(x, dof, n).placed(points_at(np.arange(len(x))))


def bumpy_block(rng: np.random.Generator, bumps: float) -> tuple[Array, Ints]:
    """A unit cube of 3 x 3 x 3 cells with shaken vertices, and its closed surface."""
    number = np.arange(64).reshape(4, 4, 4)
    tets = []
    for order in permutations(range(3)):
        corner = np.zeros((4, 3), dtype=np.int64)
        for step, axis in enumerate(order):
            corner[step + 1 :, axis] = 1
        if np.linalg.det(corner[1:] - corner[0]) < 0:
            corner = corner[[0, 2, 1, 3]]
        cells = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
        index = cells + corner
        tets.append(number[index[..., 0], index[..., 1], index[..., 2]])
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 4)] * 3, indexing="ij"), axis=-1)
    x = grid.reshape(-1, 3) + bumps * rng.uniform(-1.0, 1.0, (64, 3))
    return x, boundary_triangles(np.concatenate(tets))


def with_points(x: Array, triangles: Ints, points: Array) -> tuple[Array, ContactSet]:
    """Vertices and a contact set with one tiny loose triangle as candidate for each point."""
    offsets = np.array([[0.01, 0, 0], [0, 0.01, 0], [-0.01, -0.01, 0]])
    loose = (points[:, None, :] + offsets).reshape(-1, 3)
    nodes = len(x) + np.arange(len(loose)).reshape(-1, 3)
    pair = ContactPair("points on block", nodes, np.full(nodes.shape, 1 / 3), triangles)
    x = np.vstack([x, loose])
    return x, ContactSet([pair], len(x), ALARM)


def segment_distances(p: Array, a: Array, b: Array) -> Array:
    """Of a point from segments with these ends (t, 3): (t,)."""
    along = b - a
    t = np.clip(((p - a) * along).sum(axis=1) / (along * along).sum(axis=1), 0.0, 1.0)
    found: Array = np.linalg.norm(p - a - t[:, None] * along, axis=1)
    return found


def triangle_distances(p: Array, corners: Array) -> Array:
    """Least squares for the foot in each plane; where it is outside, the nearest side: (t,)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    sides = np.stack([b - a, c - a], axis=2)  # (t, 3, 2)
    uv = np.linalg.pinv(sides) @ (p - a)[:, :, None]  # (t, 2, 1)
    foot = np.linalg.norm(p - a - (sides @ uv)[:, :, 0], axis=1)
    inside = (uv.min(axis=(1, 2)) >= 0.0) & (uv.sum(axis=(1, 2)) <= 1.0)
    ends = ((a, b), (b, c), (c, a))
    side = np.min([segment_distances(p, one, other) for one, other in ends], axis=0)
    return np.where(inside, foot, side)


def winding_number(p: Array, corners: Array) -> float:
    """Solid angle of the surface seen from p over 4 pi (van Oosterom and Strackee 1983)."""
    r = corners - p  # (t, 3, 3)
    length = np.linalg.norm(r, axis=2)
    a, b, c = r[:, 0], r[:, 1], r[:, 2]
    la, lb, lc = length.T
    dot = lambda u, v: np.einsum("ti,ti->t", u, v)  # noqa: E731
    numerator = np.einsum("ti,ti->t", a, np.cross(b, c))
    denominator = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
    return float(2.0 * np.arctan2(numerator, denominator).sum() / (4.0 * np.pi))


def signed_distance(p: Array, corners: Array) -> float:
    distance = float(triangle_distances(p, corners).min())
    return -distance if winding_number(p, corners) > 0.5 else distance


@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 10_000), bumps=st.sampled_from([0.0, 0.02, 0.08]))
def test_gap_is_the_signed_distance_to_a_closed_surface(seed: int, bumps: float) -> None:
    rng = np.random.default_rng(seed)
    x, triangles = bumpy_block(rng, bumps)
    points = rng.uniform(-0.3, 1.3, (60, 3))
    expected = np.array([signed_distance(p, x[triangles]) for p in points])
    x, contacts = with_points(x, triangles, points)
    detection = contacts.detect(x)
    gaps = np.full(len(points), np.inf)
    gaps[detection.slots] = detection.gap
    near = np.abs(expected) < ALARM
    np.testing.assert_allclose(gaps[near], expected[near], rtol=0, atol=1e-12)
    assert np.all(np.isinf(gaps[~near]))
    assert near.sum() > 10
    assert (expected[near] < 0).any()


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_rows_are_the_gradient_of_the_gap(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, triangles = bumpy_block(rng, 0.05)
    x, contacts = with_points(x, triangles, rng.uniform(-0.2, 1.2, (80, 3)))
    detection = contacts.detect(x)
    H = contact_rows(detection, placed_nodes(x, 3 * np.arange(len(x)), x.size)).rows.H
    step = 1e-6 * rng.standard_normal(x.shape)
    ahead, behind = contacts.detect(x + step), contacts.detect(x - step)
    common = [set(d.slots[d.gap < ALARM - 1e-4].tolist()) for d in (detection, ahead, behind)]
    slots = np.array(sorted(common[0] & common[1] & common[2]))
    assert len(slots) > 20
    gap = [d.gap[np.searchsorted(d.slots, slots)] for d in (ahead, behind)]
    predicted = 2.0 * (H @ step.ravel())[np.searchsorted(detection.slots, slots)]
    error = np.abs(gap[0] - gap[1] - predicted) / 2e-6
    # where two closest points tie the gap has a kink; a seed that hits it within 1e-6 is rare
    assert np.sort(error)[-2] < 1e-5
    assert np.median(error) < 1e-7


def test_unit_normals_and_balanced_coefficients() -> None:
    rng = np.random.default_rng(3)
    x, triangles = bumpy_block(rng, 0.05)
    x, contacts = with_points(x, triangles, rng.uniform(-0.2, 1.2, (80, 3)))
    detection = contacts.detect(x)
    np.testing.assert_allclose(np.linalg.norm(detection.normal, axis=1), 1.0, atol=1e-12)
    # a rigid translation closes no gap
    np.testing.assert_allclose(detection.coefficients.sum(axis=1), 0.0, atol=1e-12)
    assert np.all(np.diff(detection.slots) > 0)


def test_rigid_rotation_changes_no_gap() -> None:
    rng = np.random.default_rng(4)
    x, triangles = bumpy_block(rng, 0.05)
    x, contacts = with_points(x, triangles, rng.uniform(-0.2, 1.2, (80, 3)))
    detection = contacts.detect(x)
    H = contact_rows(detection, placed_nodes(x, 3 * np.arange(len(x)), x.size)).rows.H
    spin = np.cross(np.array([0.3, -0.5, 0.8]), x)  # (v, 3)
    np.testing.assert_allclose(H @ spin.ravel(), 0.0, atol=1e-12)
    Q, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    Q *= np.sign(np.linalg.det(Q))
    turned = contacts.detect(x @ Q.T)
    np.testing.assert_array_equal(turned.slots, detection.slots)
    np.testing.assert_allclose(turned.gap, detection.gap, atol=1e-12)


def test_gap_is_continuous_along_a_path_around_a_closed_body() -> None:
    rng = np.random.default_rng(5)
    x, triangles = bumpy_block(rng, 0.03)
    angle = np.linspace(0.0, 2 * np.pi, 4001)
    radius = 0.62 + 0.12 * np.sin(7 * angle)  # in and out of the body, over edges and corners
    path = 0.5 + radius[:, None] * np.stack(
        [np.cos(angle), np.sin(angle), 0.9 * np.cos(2 * angle)], axis=1
    )
    x, contacts = with_points(x, triangles, path)
    detection = contacts.detect(x)
    assert detection.gap.min() < -0.02
    gap = np.minimum(np.full(len(path), ALARM), np.inf)
    gap[detection.slots] = detection.gap
    step = np.linalg.norm(np.diff(path, axis=0), axis=1)
    # a distance cannot change faster than the point moves
    assert np.all(np.abs(np.diff(gap)) <= step + 1e-12)


@pytest.mark.parametrize("gap", [1e-3, 1e-9, 1e-14, 0.0, -1e-14, -1e-9, -1e-3])
@pytest.mark.parametrize("where", ["face", "edge", "corner"])
def test_touching_is_exact_to_rounding(gap: float, where: str) -> None:
    """Over a face, an edge and a corner of a plane made of four triangles."""
    x = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0]], dtype=float)
    triangles = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    at = {"face": [0.5, 0.2], "edge": [0.25, 0.25], "corner": [0.5, 0.5]}[where]
    x, contacts = with_points(x, triangles, np.array([[*at, gap]]))
    detection = contacts.detect(x)
    assert detection.gap == pytest.approx([gap], abs=1e-17)
    np.testing.assert_allclose(detection.normal, [[0, 0, 1]], atol=1e-6)
