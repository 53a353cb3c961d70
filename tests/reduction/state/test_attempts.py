"""More modes and elements until a state basis is as exact as wanted, and the refusal where it is not."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from tauten.model import Robot
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Snapshots
from tauten.reduction.contact import ContactBasis
from tauten.reduction.state import StateBasisError, StateSettings, attempts, reduce, reduce_states
from tauten.reduction.state.held_out import within_share

COARSE = StateSettings(motion=3e-2, responses=0, sample=0.2)


def test_modes_and_elements_are_added_until_the_error_is_within_the_goal(
    thumb: Robot[NodalBody], thumb_ramp: Snapshots, thumb_basis: ContactBasis
) -> None:
    said: list[tuple[float, str]] = []
    once = reduce_states(thumb, thumb_ramp, thumb_basis, COARSE)
    goal = 0.5 * once.origin.tip_max
    finer = replace(COARSE, goal=goal)
    more = reduce_states(
        thumb, thumb_ramp, thumb_basis, finer, lambda share, what: said.append((share, what))
    )
    assert more.origin.tip_max <= goal
    assert more.r > once.r
    assert len(more.elements) > len(once.elements)
    size = f"{more.r} modes, {len(more.elements)} elements, held-out loads"
    (number, checks) = re.fullmatch(rf"attempt (\d): {size} \d+ of (\d+)", said[-1][1]).groups()
    assert (f"attempt {number}: {size} 1 of {checks}") in [what for _, what in said]
    done = int(number) / reduce.ATTEMPTS / len(reduce.RANGES)
    assert sum(share for share, _ in said) == pytest.approx(done)


def test_refusal_names_every_attempt_and_what_a_step_takes(
    thumb: Robot[NodalBody],
    thumb_ramp: Snapshots,
    thumb_basis: ContactBasis,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(reduce, "ATTEMPTS", 2)
    monkeypatch.setattr(reduce, "RANGES", (1.0,))
    with pytest.raises(StateBasisError, match=r"where 1e-06 mm are allowed. 2 tried") as refused:
        reduce_states(thumb, thumb_ramp, thumb_basis, replace(COARSE, goal=1e-9))
    tried = re.findall(r"(\d+) modes and (\d+) elements take the tip up to", str(refused.value))
    assert len(tried) == 2
    assert int(tried[0][1]) < int(tried[1][1])
    assert re.search(
        r"a time step takes \S+ ms of processor time, one of the full", str(refused.value)
    )


def test_no_modes_are_added_to_a_model_that_is_slower_than_the_full_one(
    thumb: Robot[NodalBody],
    thumb_ramp: Snapshots,
    thumb_basis: ContactBasis,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(reduce, "RANGES", (1.0,))
    monkeypatch.setattr(attempts, "FAST", 0.0)
    monkeypatch.setattr(attempts, "SLOWER", 0.0)
    with pytest.raises(StateBasisError, match=r"1 tried.*Serve the full model"):
        reduce_states(thumb, thumb_ramp, thumb_basis, replace(COARSE, goal=1e-9))


def test_a_smaller_range_is_taken_where_the_whole_one_needs_too_many_modes(
    thumb: Robot[NodalBody],
    thumb_ramp: Snapshots,
    thumb_basis: ContactBasis,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two modes follow the first half of the way, not all of it; the origin says so."""
    monkeypatch.setattr(reduce, "ATTEMPTS", 1)
    few = replace(COARSE, r=2, sample=0.01)
    whole = reduce_states(thumb, thumb_ramp, thumb_basis, few)
    assert whole.origin.position_share == 1.0
    half = reduce_states(
        thumb, thumb_ramp, thumb_basis, replace(few, goal=0.9 * whole.origin.tip_max)
    )
    assert half.origin.position_share == 0.5
    assert half.origin.tip_max <= 0.9 * whole.origin.tip_max
    used = within_share(thumb_ramp, 0.5)
    assert 0.4 < len(used) / len(thumb_ramp) < 0.6
    assert np.abs(used.position).max() <= 0.5 * np.abs(thumb_ramp.position).max()
