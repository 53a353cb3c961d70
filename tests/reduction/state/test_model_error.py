"""The tip error estimated at one state is near the distance between the two models."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.robots.bodies import beam_robot, box_mesh

from tauten.model import EmptySpace, Robot, Simulator
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Design, Run, Snapshots, run_campaign
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


def test_a_rotation_that_is_a_goal_counts(tmp_path: Path) -> None:
    """By the size of the robot; of a beam that was bent to one side, under a force to another one."""
    region = {"kind": "half_space", "point": [0.0999, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}
    turn = {"name": "tip", "kind": "frame", "region": region, "weight": [0, 0, 0, 1, 1, 1]}
    size = (0.1, 0.02, 0.02)
    beam = beam_robot(box_mesh(size, (6, 2, 2)), size, effectors=[turn])
    levels, nothing = np.linspace(0.02, 0.2, 10), np.zeros(10)
    aside = Run(np.zeros((1, 10)), np.zeros((3, 10)), np.stack([nothing, levels, nothing]))
    found = run_campaign(beam, Design("aside", (aside,)), tmp_path)
    space = EmptySpace(0)
    states = reduce_states(beam, found, space, StateSettings(r=2, responses=0))
    up = np.zeros(3), np.array([0.0, 0.0, 0.2])
    near = reduced_robot(beam, states).loaded(*up)
    one, other = settled(near, space, 0.0), settled(beam.loaded(*up), "full", 0.0)
    turns = [Rotation.from_quat(s.effector_values[3:], scalar_first=True) for s in (one, other)]
    missing = beam.size * (turns[0].inv() * turns[1]).magnitude()
    assert missing > 1e-3
    estimate = TipCheck(near, space)(one.state, one.effort, np.zeros(1))
    assert estimate == pytest.approx(missing, rel=0.02)
