"""Clouds of points on the wire: numbers come back, damaged and wrong ones are refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tauten.service.wire import (
    CONTACT_FIELDS,
    LARGEST_CLOUD,
    SKIN_FIELDS,
    Cloud,
    Rejection,
    RejectionReason,
    decode_cloud,
    encode_cloud,
)

VALUES = np.arange(60_000, dtype=np.float32).reshape(-1, 3) / 7.0
PAYLOAD = encode_cloud(Cloud(12_000_000_034, "base", VALUES), SKIN_FIELDS)


def test_numbers_come_back() -> None:
    found = decode_cloud(PAYLOAD, SKIN_FIELDS)
    assert isinstance(found, Cloud)
    assert (found.stamp, found.frame) == (12_000_000_034, "base")
    assert np.array_equal(found.values, VALUES)


def test_an_empty_cloud_comes_back() -> None:
    payload = encode_cloud(
        Cloud(1, "base", np.zeros((0, len(CONTACT_FIELDS)), np.float32)), CONTACT_FIELDS
    )
    found = decode_cloud(payload, CONTACT_FIELDS)
    assert isinstance(found, Cloud)
    assert found.values.shape == (0, len(CONTACT_FIELDS))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_is_refused(value: float) -> None:
    payload = encode_cloud(Cloud(1, "base", np.full((2, 3), value, np.float32)), SKIN_FIELDS)
    check_refused(payload, RejectionReason.NOT_FINITE)


def test_other_fields_are_refused() -> None:
    payload = encode_cloud(Cloud(1, "base", np.zeros((2, 6), np.float32)), CONTACT_FIELDS)
    check_refused(payload, RejectionReason.WRONG_SHAPE)


def test_a_large_one_is_refused_before_it_is_read() -> None:
    check_refused(b"\0" * (LARGEST_CLOUD + 1), RejectionReason.TOO_LARGE)


@given(st.integers(0, 340), st.binary(min_size=1, max_size=8))
def test_damage_is_refused_or_harmless(place: int, damage: bytes) -> None:
    payload = encode_cloud(Cloud(1, "base", VALUES[:20]), SKIN_FIELDS)
    damaged = payload[:place] + damage + payload[place + len(damage) :]
    found = decode_cloud(damaged, SKIN_FIELDS)
    assert isinstance(found, Rejection) or np.isfinite(found.values).all()
    assert isinstance(decode_cloud(payload[:place], SKIN_FIELDS), Rejection)


def check_refused(payload: bytes, reason: RejectionReason) -> None:
    """A message is refused for a reason."""
    found = decode_cloud(payload, SKIN_FIELDS)
    assert isinstance(found, Rejection)
    assert found.reason is reason
