"""Modes that normal and tangential forces share, beside unit columns."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.friction import shared_modes_case


@pytest.mark.long
def test_modes_alone_lose_what_unit_columns_recover() -> None:
    case = shared_modes_case("finger", "reduced", np.array([0.022]), steps=12)
    assert case.steps >= 1
    assert case.lost > 0.1
    assert case.natural > 1e-5
    assert case.left < 1e-8
