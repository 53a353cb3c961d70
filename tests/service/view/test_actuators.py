"""Drawings of actuators: angles, travels, springs and colours show their values."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.model import ActuatorKind
from tauten.service.view.picture.actuators import (
    MIDDLE,
    NO_PRESSURE,
    PRESSURE,
    SLACK,
    TIGHT,
    VACUUM,
    cable_colour,
    chamber_colour,
    effort_share,
    travel_pieces,
    turn_pieces,
    zigzag,
)
from tauten.service.wire import DescribedActuator

AXIS = np.array([0.6, 0.0, 0.8])
START = np.array([0.1, -0.2, 0.3])


@pytest.mark.parametrize("angle", [-2.0, 0.0, 0.3, 3.0])
def test_the_hand_of_a_drive_is_turned_by_its_angle(angle: float) -> None:
    axis, zero, now, *arc = turn_pieces(START, AXIS, angle, 0.05)
    assert np.cross(axis[1] - axis[0], AXIS) == pytest.approx(0.0)
    first, last = zero[1] - START, now[1] - START
    assert first @ AXIS == pytest.approx(0.0, abs=1e-15)
    turned = np.arctan2(AXIS @ np.cross(first, last), first @ last)  # right-handed about the axis
    assert turned == pytest.approx(angle)
    rim = np.array(arc)
    assert rim[0, 0] == pytest.approx(zero[1])
    assert rim[-1, 1] == pytest.approx(now[1])
    assert np.linalg.norm(rim - START, axis=2) == pytest.approx(0.05)


def test_the_bars_of_a_slide_are_apart_by_its_travel() -> None:
    pieces = travel_pieces(START, AXIS, 0.02, 0.05)
    rest, now = pieces[1].mean(axis=0), pieces[2].mean(axis=0)
    assert now == pytest.approx(START)
    assert now - rest == pytest.approx(0.02 * AXIS)


def test_a_spring_is_as_long_as_it_is_stretched() -> None:
    pieces = zigzag(START, 3.0 * AXIS, 0.04, 0.002)
    assert pieces[0, 0] == pytest.approx(START, rel=1e-6)
    assert pieces[-1, 1] == pytest.approx(START + 0.04 * AXIS, rel=1e-6)
    assert pieces[1:, 0] == pytest.approx(pieces[:-1, 1])


def test_colours_show_efforts() -> None:
    assert [cable_colour(share) for share in (0.0, 0.5, 1.0)] == [SLACK, MIDDLE, TIGHT]
    assert [chamber_colour(share) for share in (-1.0, 0.0, 1.0)] == [VACUUM, NO_PRESSURE, PRESSURE]
    supply = DescribedActuator(
        name="bellows",
        kind=ActuatorKind.CHAMBER,
        position=(-1e-5, 1e-5),
        effort=(-2e4, 5e4),
        rate=1e-5,
        flexibility=0.0,
    )
    assert effort_share(supply, 5e4) == 1.0
    assert effort_share(supply, -2e4) == pytest.approx(0.4)
    assert effort_share(supply, float("nan")) == 0.0
