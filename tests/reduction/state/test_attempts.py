"""More modes and elements until a state basis is as exact as wanted, and the refusal where it is not."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tauten.model import Robot
from tauten.model.numerics import Array
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Snapshots, narrowed, ramp, run_campaign
from tauten.reduction.contact import ContactBasis
from tauten.reduction.state import (
    StateBasisError,
    StateSettings,
    attempts,
    held_out,
    reduce,
    reduce_states,
)
from tauten.reduction.state.held_out import Report

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
    assert not any(what.endswith(": ") for _, what in said), "a number without what is done"
    done = int(number) / reduce.ATTEMPTS
    assert sum(share for share, _ in said) == pytest.approx(done)


def test_elements_alone_are_added_where_the_modes_suffice(
    thumb: Robot[NodalBody], thumb_ramp: Snapshots, thumb_basis: ContactBasis
) -> None:
    exact = replace(COARSE, motion=1e-4)
    once = reduce_states(thumb, thumb_ramp, thumb_basis, exact)
    more = reduce_states(
        thumb, thumb_ramp, thumb_basis, replace(exact, goal=0.5 * once.origin.tip_max)
    )
    assert more.r == once.r
    assert len(more.elements) > len(once.elements)


def test_refusal_names_every_attempt_and_what_a_step_takes(
    thumb: Robot[NodalBody],
    thumb_ramp: Snapshots,
    thumb_basis: ContactBasis,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(reduce, "ATTEMPTS", 2)
    with pytest.raises(StateBasisError, match=r"where 1e-06 mm are allowed. 2 tried") as refused:
        reduce_states(thumb, thumb_ramp, thumb_basis, replace(COARSE, goal=1e-9))
    tried = re.findall(r"(\d+) modes and (\d+) elements take the tip up to", str(refused.value))
    assert len(tried) == 2
    assert int(tried[0][0]) < int(tried[1][0])
    assert re.search(
        r"a time step takes \S+ ms of processor time, one of the full", str(refused.value)
    )


def test_no_modes_are_added_to_a_model_that_is_slower_than_the_full_one(
    thumb: Robot[NodalBody],
    thumb_ramp: Snapshots,
    thumb_basis: ContactBasis,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(attempts, "FAST", 0.0)
    monkeypatch.setattr(attempts, "SLOWER", 0.0)
    with pytest.raises(StateBasisError, match=r"1 tried.*Serve the full model"):
        reduce_states(thumb, thumb_ramp, thumb_basis, replace(COARSE, goal=1e-9))


def test_a_smaller_range_is_taken_where_the_whole_one_needs_too_many_modes(
    thumb: Robot[NodalBody],
    thumb_ramp: Snapshots,
    thumb_basis: ContactBasis,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two modes follow the first half of the way, not all of it; the origin says so."""
    monkeypatch.setattr(reduce, "ATTEMPTS", 1)
    few = replace(COARSE, r=2, sample=0.01)
    whole = reduce_states(thumb, thumb_ramp, thumb_basis, few)
    assert whole.origin.position_share == 1.0
    reached: list[float] = []

    def narrower(share: float, report: Report) -> Snapshots:
        close = narrowed(thumb, thumb_ramp.position, share)
        found = run_campaign(close, ramp(close, share * 5e-4), tmp_path)
        reached.append(float(np.abs(found.position).max() / np.abs(thumb_ramp.position).max()))
        return found

    goal = 0.9 * whole.origin.tip_max
    half = reduce_states(thumb, thumb_ramp, thumb_basis, replace(few, goal=goal), narrower=narrower)
    assert half.origin.position_share == 0.5
    assert half.origin.tip_max <= goal
    assert reached == pytest.approx([0.5], rel=1e-6)


def test_whole_runs_are_held_out_of_five_and_more(thumb_ramp: Snapshots) -> None:
    """No load occurs both in training and among what is held out."""
    steps = np.arange(len(thumb_ramp))
    for runs in (5, 15):
        split = replace(thumb_ramp, run=steps * runs // len(steps))
        held = held_out.held_out_snapshots(split)
        assert not np.intersect1d(split.run[held], split.run[~held]).size
        assert len(np.unique(split.run[held])) == runs // 5
    one = held_out.held_out_snapshots(thumb_ramp)
    assert one.sum() == len(steps) // 5


@pytest.mark.parametrize("actuators", [1, 3, 8])
def test_the_mean_error_is_that_over_the_range_of_the_actuators(actuators: int) -> None:
    """As of points spread evenly in a ball; runs go from its centre to its surface in even steps."""
    rng = np.random.default_rng(0)
    ends = rng.standard_normal((2000, actuators))
    ends /= np.linalg.norm(ends, axis=1, keepdims=True)
    shares = np.arange(1, 41) / 40.0
    run = np.repeat(np.arange(len(ends)), len(shares))
    weights = held_out.range_weights(run, actuators)
    points = (ends[:, None] * shares[:, None]).reshape(-1, actuators)
    direction = rng.standard_normal((100_000, actuators))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    even = direction * rng.uniform(size=(len(direction), 1)) ** (1.0 / actuators)

    def error(command: Array) -> Array:
        return np.sum(command**2, axis=1) + np.maximum(command[:, 0], 0.0)

    mean = np.average(error(points), weights=weights)
    assert mean == pytest.approx(error(even).mean(), rel=0.05)
    assert actuators == 1 or mean > 1.3 * error(points).mean(), "most of them are near the centre"


def test_equilibria_that_are_compared_have_the_ends_of_runs() -> None:
    """Every second one of runs of eight left all ends out."""
    run = np.repeat([0, 1], 8)
    assert held_out.spread_places(run, 10, whole=False).tolist() == [1, 3, 5, 7, 9, 11, 13, 15]
    assert held_out.spread_places(run, 16, whole=False).tolist() == list(range(16))


def test_whole_runs_are_compared_where_the_way_matters() -> None:
    run = np.repeat([4, 9, 14, 19], 5)
    assert held_out.spread_places(run, 12, whole=True).tolist() == [*range(5, 10), *range(15, 20)]
    assert held_out.spread_places(run, 3, whole=True).tolist() == list(range(15, 20))
    assert held_out.spread_places(run, 20, whole=True).tolist() == list(range(20))


def test_hopeless_attempts_are_compared_at_a_few_equilibria_alone(
    thumb: Robot[NodalBody],
    thumb_ramp: Snapshots,
    thumb_basis: ContactBasis,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(held_out, "FIRST_CHECKS", 3)
    every = int(held_out.held_out_snapshots(thumb_ramp).sum())
    ends: dict[float, set[str]] = {1e-9: set(), 1.0: set()}
    coarse = replace(COARSE, r=1)
    for goal, said in ends.items():
        with suppress(StateBasisError):
            reduce_states(
                thumb,
                thumb_ramp,
                thumb_basis,
                replace(coarse, goal=goal),
                lambda share, what, said=said: said.add(what.split(" of ")[-1]),
            )
    assert {"3"} == ends[1e-9] & {"3", str(every)}
    assert {"3", str(every)} == ends[1.0] & {"3", str(every)}
