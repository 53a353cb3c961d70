"""The tip error estimated at one state is near the distance between the two models."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.model import Robot, Simulator
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Snapshots
from tauten.reduction.contact import ContactBasis
from tauten.reduction.state import (
    ReducedBody,
    StateSettings,
    TipCheck,
    reduce_states,
    reduced_robot,
)


@pytest.fixture(scope="module")
def reduced(
    thumb: Robot[NodalBody], thumb_ramp: Snapshots, thumb_basis: ContactBasis
) -> Robot[ReducedBody]:
    states = reduce_states(thumb, thumb_ramp, thumb_basis, StateSettings(r=8, responses=0))
    assert states.origin.tip_mean <= states.origin.tip_max < 5e-4  # of 50 mm
    return reduced_robot(thumb, states)


def settled(
    robot: Robot[NodalBody] | Robot[ReducedBody], contact: object, position: float
) -> Simulator:
    simulator = Simulator(robot, contact)  # type: ignore[arg-type]
    for share in (0.25, 0.5, 0.75, 1.0):
        assert simulator.settle(position=[share * position], tolerance=1e-6).converged
    return simulator


@pytest.mark.parametrize(
    ("gravity", "outside"), [((0.0, 0.0, -9.81), False), ((0.0, 60.0, -9.81), True)]
)
def test_estimate_is_the_distance_to_the_full_model(
    reduced: Robot[ReducedBody],
    thumb_basis: ContactBasis,
    gravity: tuple[float, float, float],
    outside: bool,
) -> None:
    """Trained on bending in one plane: a load across it is outside of the basis."""
    load, position = (np.array(gravity), np.zeros(3)), 0.006
    near, full = reduced.loaded(*load), reduced.body.full.loaded(*load)
    simulator = settled(near, thumb_basis, position)
    true = float(np.linalg.norm(simulator.effector - settled(full, "full", position).effector))
    found = TipCheck(near, thumb_basis)(simulator.state, simulator.effort, np.array([position]))
    assert (true > 1e-3) == outside
    assert found == pytest.approx(true, rel=0.5, abs=1e-4)


def test_state_that_is_not_finite_is_infinitely_far(
    reduced: Robot[ReducedBody], thumb_basis: ContactBasis
) -> None:
    state = reduced.rest()
    state.q[0] = np.nan
    assert TipCheck(reduced, thumb_basis)(state, np.zeros(1), np.zeros(1)) == np.inf
