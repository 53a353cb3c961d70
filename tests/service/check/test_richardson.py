"""Extrapolation and grading, without robots."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.service.check import LoadedState
from tauten.service.check.mesh_error import load_error
from tauten.service.check.references import Reference, richardson, sources_of


@pytest.mark.parametrize("order", [1.1, 1.2, 2.0, 3.0])
def test_a_power_law_is_extrapolated_to_its_limit(order: float) -> None:
    limit, slope = np.array([0.3, -2.0, 5.0]), np.array([0.2, 0.1, -0.4])
    found = richardson(*(limit + slope * h**order for h in (4.0, 2.0, 1.0)))
    assert found is not None
    np.testing.assert_allclose(found[0], limit, rtol=1e-12)
    assert found[1] == pytest.approx(order)


def test_values_without_an_order_are_not_extrapolated() -> None:
    """Diverging, hardly converging, and faster than any element."""
    for values in ((1.0, 1.1, 1.3), (1.0, 1.1, 1.19), (1.0, 2.0, 2.001)):
        assert richardson(*(np.array([value]) for value in values)) is None


def test_values_that_do_not_change_are_their_own_limit() -> None:
    still = [np.array([value]) for value in (0.5, 0.4, 0.4)]
    assert richardson(*still) == (pytest.approx(0.4), None)
    assert richardson(*(np.zeros(1) for _ in range(3))) == (pytest.approx(0.0), None)


def test_ways_to_a_reference_are_named_once_that_of_most_loads_first() -> None:
    a, b, c = (Reference(LoadedState(True, (0.0,), (0.0,), 0.0), way, None) for way in "abc")
    assert sources_of((None, None)) == ""
    assert sources_of((b, None, b)) == "b"
    assert sources_of((a, b, b, c)) == "b; under other loads a or c"


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_mesh_is_too_stiff_where_it_needs_more_effort_of_either_sign(sign: float) -> None:
    """A pressure that sucks counts as one that blows: 10 % more of it is +10 %."""
    reference = LoadedState(True, (sign * 2.0, 0.5), (0.0, 0.0, 0.0), 0.0)
    state = LoadedState(True, (sign * 2.2, 0.45), (0.003, 0.004, 0.0), 0.0)
    found = load_error(state, reference, (2.0, 0.0))
    assert found.effort == pytest.approx(0.1)
    assert found.tip == pytest.approx(0.005)
    assert found.contact is None
    softer = load_error(reference, state, (2.2, 0.0))
    assert softer.effort == pytest.approx(-0.2 / 2.2)
