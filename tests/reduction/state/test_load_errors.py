"""Errors under other loads than the training's: measured as by hand, and small after training on loads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.thumb import write_thumb

from benchmarks.steps import ForeignLoadError, load_errors
from tauten.model import EmptySpace, Robot, Simulator
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Design, Snapshots, exploring, run_campaign, touched_robot
from tauten.reduction.contact import ContactBasis, tip_errors
from tauten.reduction.state import (
    StateBasis,
    StateBasisError,
    StateSettings,
    reduce_states,
    reduced_robot,
)


@pytest.fixture(scope="module")
def of_ramp(
    thumb: Robot[NodalBody], thumb_ramp: Snapshots, thumb_basis: ContactBasis
) -> StateBasis:
    return reduce_states(thumb, thumb_ramp, thumb_basis, StateSettings(r=6, responses=0))


def errors(
    thumb: Robot[NodalBody], states: StateBasis, basis: ContactBasis, swing: float
) -> dict[str, ForeignLoadError]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("benchmarks.steps.load_comparison.POSTURES", 1)
        patch.setattr("benchmarks.steps.load_comparison.SWING", swing)
        found = load_errors(thumb, reduced_robot(thumb, states), basis)
    return {error.kind: error for error in found}


def test_payload_error_is_the_distance_of_two_models_that_carry_it(
    thumb: Robot[NodalBody], of_ramp: StateBasis, thumb_basis: ContactBasis
) -> None:
    found = errors(thumb, of_ramp, thumb_basis, 0.05)["payload"]
    assert (found.cases, found.lost) == (12, 0)
    force = np.array([0.0, 0.2 * 9.81 * thumb.body.moving_mass, 0.0])
    tips = []
    for robot in (thumb, reduced_robot(thumb, of_ramp)):
        simulator = Simulator(robot.loaded(thumb.gravity, force), contact="full")
        assert simulator.settle(position=[0.0], tolerance=1e-7).converged
        tips.append(simulator.effector)
    assert found.largest >= 0.999 * np.linalg.norm(tips[0] - tips[1])
    assert found.largest < 2.0 * np.linalg.norm(tips[0] - tips[1])


@pytest.mark.slow
def test_training_on_loads_removes_most_of_their_error(
    thumb: Robot[NodalBody], of_ramp: StateBasis, thumb_basis: ContactBasis, tmp_path: Path
) -> None:
    snapshots = run_campaign(thumb, exploring(thumb), tmp_path)
    states = reduce_states(
        thumb, snapshots.select(snapshots.converged), thumb_basis, StateSettings(r=12, responses=4)
    )
    before = errors(thumb, of_ramp, thumb_basis, 2.0)
    after = errors(thumb, states, thumb_basis, 2.0)
    assert all(error.lost == 0 for error in after.values())
    for kind in ("tilt", "payload"):
        assert after[kind].largest < 0.3 * before[kind].largest
        assert after[kind].largest < 0.01 * thumb.size
    assert after["motion"].largest < 0.02 * thumb.size


def test_refusal_says_how_many_modes_elements_and_snapshots_it_took(of_ramp: StateBasis) -> None:
    size = f"of {of_ramp.r} modes and {len(of_ramp.elements)} elements"
    sentence = f"{size}, from {of_ramp.origin.snapshots} snapshots, takes the tip up to"
    with pytest.raises(StateBasisError, match=sentence):
        of_ramp.check_tip(1e-9)


@pytest.mark.slow
def test_the_error_against_spheres_falls(tmp_path: Path) -> None:
    touched = touched_robot(write_thumb(tmp_path), ["skin"])
    assert touched is not None
    robot, runs = touched.robot, exploring(touched.robot, 0, touched).runs
    designs = {
        "free": runs[1:8],  # tilted and with payload
        "pressed": (*runs[1:8], *runs[-14:-4]),
        "others": runs[-4:],
    }
    found = {
        name: run_campaign(robot, Design(name, chosen), tmp_path / name)
        for name, chosen in designs.items()
    }
    found = {name: snapshots.select(snapshots.converged) for name, snapshots in found.items()}
    space, settings = EmptySpace(robot.n_c), StateSettings(r=20, responses=0)
    mean = {}
    for name in ("free", "pressed"):
        states = reduce_states(robot, found[name], space, settings)
        assert (states.origin.pressed_max is None) == (name == "free")
        errors = tip_errors(reduced_robot(robot, states), found["others"], space).error
        mean[name] = float(np.mean(errors))  # NaN where one has no equilibrium
    assert mean["pressed"] < 0.7 * mean["free"]
