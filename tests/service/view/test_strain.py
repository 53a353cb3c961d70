"""Strain of the skin, ranges of plots, and numbers of forces."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.service.view.charts import padded_range
from tauten.service.view.picture.round_numbers import rounded_up
from tauten.service.view.picture.strain import largest_strain, strain_bar

TRIANGLES = np.array([[0, 1, 2], [1, 3, 2]])
REST = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 2.0, 0.0]], np.float32)


def test_strain_is_that_of_the_direction_that_stretches_most() -> None:
    turn = np.array([[0.0, -1.0, 0.0], [0.6, 0.0, -0.8], [0.8, 0.0, 0.6]])  # a rotation
    assert turn @ turn.T == pytest.approx(np.eye(3))
    for stretch, strain in (((1.0, 1.0), 0.0), ((1.2, 0.95), 0.2), ((1.1, 0.7), 0.3)):
        now = (REST * [*stretch, 1.0]) @ turn.T + [3.0, 2.0, 1.0]
        assert largest_strain(REST, now.astype(np.float32), TRIANGLES) == pytest.approx(
            strain, abs=1e-6
        )
    sheared = REST + np.array([0.5, 0.0, 0.0], np.float32) * REST[:, 1:2]
    values = np.linalg.svd([[1.0, 0.5], [0.0, 1.0]], compute_uv=False)
    assert largest_strain(REST, sheared, TRIANGLES) == pytest.approx(np.abs(values - 1.0).max())


def test_the_bar_ends_at_a_round_number() -> None:
    assert [rounded_up(one) for one in (0.011, 0.02, 0.3, 0.7)] == pytest.approx(
        [0.02, 0.02, 0.5, 1.0]
    )
    assert "20 %" in strain_bar(0.2)


def test_noise_is_not_drawn_at_full_height() -> None:
    noise = 1e-15 * np.random.default_rng(0).standard_normal(100)
    low, high = padded_range(noise, 0.5, None)
    assert high - low == pytest.approx(0.5)
    assert low < 0.0 < high


def test_a_range_stays_while_values_are_within_it() -> None:
    first = padded_range(np.array([0.0, 10.0]), 0.5, None)
    assert first[0] < 0.0
    assert first[1] > 10.0
    assert padded_range(np.array([2.0, 9.0]), 0.5, first) == first
    assert padded_range(np.array([2.0, 12.0]), 0.5, first)[1] > 12.0
    assert np.ptp(padded_range(np.array([2.0, 2.5]), 0.5, first)) < 1.0, "and not for ever"
    assert padded_range(np.array([np.nan, 1.0]), 0.5, None) == (0.75, 1.25)


def test_a_plot_of_small_distances_begins_at_zero() -> None:
    """The one tick that it had was that of zero in its middle."""
    low, high = padded_range(np.array([0.0, 0.1]), 2.0, None)
    assert -0.2 < low <= 0.0 and high == pytest.approx(low + 2.0)
    assert padded_range(np.array([-1.0, 0.0]), 2.0, None) == (-1.5, 0.5)
