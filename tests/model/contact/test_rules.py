"""What a candidate touches: borders of open faces, its own neighbourhood, deep penetration."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauten.model.contact import BLOCK, ContactPair, ContactSet, contact_rows
from tauten.model.numerics import Array, Ints
from tauten.model.points import NodeMotion, Placed, points_at

ALARM = 2e-3


def placed_nodes(x: Array, dof: Ints, n: int) -> Placed:
    """The nodes themselves at one state."""
    return NodeMotion(x, dof, n).placed(points_at(np.arange(len(x))))


def sheet(width: float, cells: int) -> tuple[Array, Ints]:
    """An open square face at z = 0 that looks up."""
    u = np.linspace(0.0, width, cells + 1)
    x = np.stack([*np.meshgrid(u, u, indexing="ij"), np.zeros((cells + 1,) * 2)], axis=-1)
    n = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]
    lower, upper = np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)
    return x.reshape(-1, 3), np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3)])


def gaps_over_sheet(points: Array, alarm: float = ALARM) -> Array:
    """Gap of loose points over a 10 mm sheet, +inf where none."""
    x, triangles = sheet(0.01, 3)
    nodes = len(x) + np.arange(3 * len(points)).reshape(-1, 3)
    pair = ContactPair("points on sheet", nodes, np.tile([1.0, 0, 0], (len(points), 1)), triangles)
    x = np.vstack([x, np.repeat(points, 3, axis=0)])
    contacts = ContactSet([pair], len(x), alarm)
    return contacts.detect(x).gaps()


inside = st.floats(1e-6, 0.01 - 1e-6)
height = st.floats(-1.99e-3, 1.99e-3)
beside = st.floats(1e-9, 1e-3)


@pytest.mark.long
@settings(deadline=None)
@given(inside, inside, height)
def test_over_an_open_face_the_gap_is_the_height(x: float, y: float, z: float) -> None:
    assert gaps_over_sheet(np.array([[x, y, z]])) == pytest.approx([z], abs=1e-15)


@settings(deadline=None)
@given(inside, beside, height, st.sampled_from(range(4)))
def test_past_the_border_of_an_open_face_there_is_no_contact(
    along: float, past: float, z: float, side: int
) -> None:
    """Above, level, below: nothing to be caught on, and no bogus penetration."""
    point = {
        0: [along, -past, z],
        1: [along, 0.01 + past, z],
        2: [-past, along, z],
        3: [0.01 + past, along, z],
    }[side]
    assert np.isinf(gaps_over_sheet(np.array([point]))).all()


def test_penetration_is_found_down_to_the_alarm_distance() -> None:
    depth = np.array([1e-6, 1e-4, 1e-3, 1.999e-3, 2.001e-3, 1e-2])
    points = np.stack([np.full(6, 4e-3), np.full(6, 7e-3), -depth], axis=1)
    np.testing.assert_allclose(gaps_over_sheet(points)[:4], -depth[:4], atol=1e-15)
    assert np.isinf(gaps_over_sheet(points)[4:]).all()


def test_positions_that_are_not_finite_are_out_of_range() -> None:
    good = [4e-3, 7e-3, 1e-3]
    points = np.array([good, [np.nan, 7e-3, 1e-3], [np.inf, 7e-3, 1e-3], [1e300, 0, 0], good])
    gaps = gaps_over_sheet(points)
    np.testing.assert_allclose(gaps[[0, 4]], 1e-3)
    assert np.isinf(gaps[1:4]).all()
    assert np.isinf(gaps_over_sheet(np.full((3, 3), np.nan))).all()


def folded_strip(angle: float) -> tuple[Array, Ints]:
    """A strip of 2 x 8 cells, 8 mm long and folded upward by `angle` halfway: one surface."""
    u, v = np.meshgrid(np.linspace(-4e-3, 4e-3, 9), np.linspace(0.0, 2e-3, 3), indexing="ij")
    half = 0.5 * angle
    x = np.stack([u * np.cos(half), v, np.abs(u) * np.sin(half)], axis=-1).reshape(-1, 3)
    n = np.arange(27).reshape(9, 3)
    a, b, c, d = n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    return x, triangles.reshape(-1, 3)


def test_a_flat_surface_does_not_touch_itself() -> None:
    x, triangles = folded_strip(0.0)
    pair = ContactPair("self", triangles, np.full(triangles.shape, 1 / 3), triangles)
    assert len(ContactSet([pair], len(x), ALARM).detect(x)) == 0


def test_a_folded_surface_touches_its_other_flank() -> None:
    """Nearly closed: every candidate away from the fold faces the other flank at its distance."""
    angle = np.pi - 0.2
    x, triangles = folded_strip(angle)
    pair = ContactPair("self", triangles, np.full(triangles.shape, 1 / 3), triangles)
    contacts = ContactSet([pair], len(x), ALARM)
    detection = contacts.detect(x)
    points = x[triangles].mean(axis=1)
    from_fold = np.hypot(points[:, 0], points[:, 2])  # (t,)
    expected = from_fold * np.sin(np.pi - angle)
    np.testing.assert_allclose(detection.gap, expected[detection.slots], atol=1e-12)
    away = np.flatnonzero((from_fold > 1.1e-3) & (from_fold < 3.9e-3))
    assert np.isin(away, detection.slots).all()
    crossed = contacts.detect(folded_strip(np.pi + 0.2)[0])  # flanks passed through each other
    np.testing.assert_allclose(crossed.gap, -expected[crossed.slots], atol=1e-12)


def test_pairs_keep_their_slots_and_are_independent() -> None:
    x, triangles = sheet(0.01, 2)
    v = len(x)
    x = np.vstack([x, x + np.array([0, 0, 0.05])])
    loose = np.array([[5e-3, 5e-3, 1e-3]] * 3 + [[5e-3, 5e-3, 0.0505]] * 3)
    nodes = 2 * v + np.arange(6).reshape(2, 3)
    weights = np.tile([1.0, 0.0, 0.0], (2, 1))
    low = ContactPair("low", nodes, weights, triangles)
    high = ContactPair("high", nodes, weights, triangles + v)
    contacts = ContactSet([low, high], 2 * v + 6, ALARM)
    detection = contacts.detect(np.vstack([x, loose]))
    assert contacts.n_slots == 4
    assert detection.slots.tolist() == [0, 3]
    assert detection.pair.tolist() == [0, 1]
    np.testing.assert_allclose(detection.gap, [1e-3, 5e-4], atol=1e-15)


def test_fixed_vertices_get_no_entries() -> None:
    x, triangles = sheet(0.01, 2)
    v = len(x)
    pair = ContactPair(
        "point", np.array([[v, v + 1, v + 2]]), np.array([[0.5, 0.3, 0.2]]), triangles
    )
    contacts = ContactSet([pair], v + 3, ALARM)
    x = np.vstack([x, np.tile([4e-3, 3e-3, 1e-3], (3, 1))])
    everything = contact_rows(
        contacts.detect(x), placed_nodes(x, 3 * np.arange(v + 3), 3 * v + 9)
    ).rows.H
    dof = np.full(v + 3, -1)
    dof[[v, v + 2]] = [0, 3]
    free = contact_rows(contacts.detect(x), placed_nodes(x, dof, 6)).rows.H
    np.testing.assert_allclose(free.toarray(), [[0, 0, 0.5, 0, 0, 0.2]], atol=1e-15)
    columns = [3 * v, 3 * v + 1, 3 * v + 2, 3 * v + 6, 3 * v + 7, 3 * v + 8]
    np.testing.assert_array_equal(everything[:, columns].toarray(), free.toarray())


def test_a_gap_does_not_depend_on_other_candidates_or_earlier_ones() -> None:
    """More candidates than are looked at together; few of them or one alone find the same."""
    rng = np.random.default_rng(0)
    points = rng.uniform(-1e-3, 11e-3, (2 * BLOCK + 10, 3)) * [1, 1, 0.1]
    first = gaps_over_sheet(points)
    assert 0 < np.isfinite(first).sum() < len(points)
    np.testing.assert_array_equal(gaps_over_sheet(points[::-1])[::-1], first)
    np.testing.assert_array_equal(gaps_over_sheet(points), first)
    alone = np.concatenate([gaps_over_sheet(point[None]) for point in points[::20]])
    np.testing.assert_array_equal(alone, first[::20])


def make(**changes: object) -> ContactSet:
    x, triangles = sheet(0.01, 2)
    arguments = {
        "nodes": np.array([[0, 1, 2]]),
        "weights": np.array([[0.2, 0.3, 0.5]]),
        "triangles": triangles,
        "alarm": ALARM,
    } | changes
    pair = ContactPair("a on b", arguments["nodes"], arguments["weights"], arguments["triangles"])
    return ContactSet([pair], len(x), arguments["alarm"])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"alarm": 0.0}, "alarm_distance is 0.0 m, it must be positive"),
        ({"nodes": np.zeros((0, 3), dtype=int)}, r"a on b: candidates have shape \(0, 3\)"),
        ({"triangles": np.array([[0, 1, 9]])}, "a on b: triangles name vertices 0 to 9"),
        ({"weights": np.array([[0.5, 0.6, 0.5]])}, "a on b: candidate 0 has weights"),
        ({"weights": np.array([[1.5, -0.5, 0.0]])}, "a on b: candidate 0 has weights"),
        ({"weights": np.array([[np.nan, 0.5, 0.5]])}, "a on b: candidate 0 has weights"),
        (
            {"triangles": np.array([[0, 1, 2], [0, 1, 3]])},
            "triangles 0 and 1 are not oriented alike",
        ),
    ],
)
def test_wrong_pairs_are_refused(changes: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make(**changes)


def test_no_pairs_no_contacts() -> None:
    contacts, nowhere = ContactSet([], 5, ALARM), np.zeros((5, 3))
    rows = contact_rows(contacts.detect(nowhere), placed_nodes(nowhere, np.arange(5), 15))
    assert rows.rows.H.shape == (0, 15)
    assert len(rows.found.gaps()) == 0


@settings(deadline=None, max_examples=20)
@given(inside, inside, height, st.floats(0.0, 1.9e-3))
def test_surfaces_are_held_at_a_distance(x: float, y: float, z: float, distance: float) -> None:
    """The gap is what remains to the distance; the normal and the rows are those of the surface."""
    vertices, triangles = sheet(0.01, 3)
    nodes = np.array([[len(vertices), len(vertices) + 1, len(vertices) + 2]])
    pair = ContactPair("point on sheet", nodes, np.array([[1.0, 0.0, 0.0]]), triangles)
    points = np.vstack([vertices, [[x, y, z]] * 3])
    near, far = (
        ContactSet([pair], len(points), ALARM, held).detect(points) for held in (0.0, distance)
    )
    assert far.gap == pytest.approx(near.gap - distance, abs=1e-15)
    assert np.array_equal(far.normal, near.normal)
    assert np.array_equal(far.coefficients, near.coefficients)


def test_the_distance_is_less_than_the_alarm_distance() -> None:
    with pytest.raises(ValueError, match="larger than the distance"):
        ContactSet([], 5, ALARM, ALARM)
