"""The record of contacts: its frames, and forces where a step has rows."""

from __future__ import annotations

import numpy as np

from tauten.model import Contacts, EmptySpace, Forces
from tauten.model.contacts import nearest_from_all_sides
from tauten.model.numerics import Array


def record(normal: Array, slots: list[int], n_slots: int) -> Contacts:
    m = len(normal)
    none = np.zeros(m)
    return Contacts(
        n_slots, np.array(slots), np.zeros(m, np.int64), none, np.zeros((m, 3)), normal, none
    )


def test_normal_and_tangents_are_right_handed_axes() -> None:
    rng = np.random.default_rng(0)
    normal = rng.normal(size=(50, 3))
    normal[0], normal[1], normal[2] = (0, 0, 1), (0, 0, -1), (1e-9, 0, -1)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    found = record(normal, list(range(50)), 50)
    axes = found.axes()
    np.testing.assert_array_equal(axes[:, 0], normal)
    np.testing.assert_allclose(
        axes @ axes.transpose(0, 2, 1), np.tile(np.eye(3), (50, 1, 1)), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(axes), 1.0, atol=1e-12)
    np.testing.assert_array_equal(found.axes(np.array([2, 0])), axes[[2, 0]])


def test_a_mode_pushes_no_candidate_out_of_range() -> None:
    """A mode reaches beyond the candidates in range; a step has no row there, and so no force."""
    found = record(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), [1, 3], 5)
    slots, lam = np.arange(5), np.array([9.0, 2.0, 9.0, 3.0, 9.0])
    loaded = Forces(np.zeros(0), np.zeros(0), slots, lam).on(found, EmptySpace(5))
    assert loaded.sliding.all() and not loaded.margin.any()  # nothing holds them
    forces = loaded.at_candidates()
    expected = np.zeros((5, 3))
    expected[1, 2], expected[3, 0] = 2.0, 3.0
    np.testing.assert_array_equal(forces, expected)
    np.testing.assert_array_equal(loaded.normal_force, [2.0, 3.0])
    np.testing.assert_array_equal(found.gaps(), [np.inf, 0.0, np.inf, 0.0, np.inf])


def test_the_nearest_contacts_come_from_all_sides_in_turn() -> None:
    """Eight above that are nearer than two beside and one of another pair: each side has its nearest one."""
    gap = np.array([*np.linspace(0.1, 0.2, 8), 1.0, 2.0, 3.0])
    pair = np.array([0] * 10 + [1])
    normal = np.array([[0.0, 0.1, 1.0]] * 8 + [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert nearest_from_all_sides(gap, pair, normal, 4).tolist() == [0, 8, 9, 10]
    assert nearest_from_all_sides(gap, pair, normal, 6).tolist() == [0, 8, 9, 10, 1, 2]
    assert len(nearest_from_all_sides(gap, pair, normal, 40)) == len(gap)
    assert len(nearest_from_all_sides(gap[:0], pair[:0], normal[:0], 40)) == 0
