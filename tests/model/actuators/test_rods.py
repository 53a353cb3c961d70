"""Cables whose least tension is negative: rods, which push as they pull."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from support.robots.bodies import CABLE, beam_robot, box_mesh, pneumatic_config

from tauten.controller import Controller, ControllerSettings, Status
from tauten.model import Robot, Simulator, State
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig, RobotFileError, validated
from tauten.model.tetra import NodalBody

SIZE = (0.1, 0.02, 0.02)
ROD = {"name": "rod", "points": [[0.01, 0.01, 0.002], [0.05, 0.01, 0.002], [0.1, 0.01, 0.002]],
       "min_tension": -20.0, "max_tension": 20.0, "min_pull": -0.01, "max_pull": 0.01,
       "max_rate": 0.1}  # fmt: skip


def built(**changes: object) -> Robot[NodalBody]:
    rod = {**ROD, **changes}
    robot = beam_robot(box_mesh(SIZE, (10, 2, 2)), SIZE, cables=[rod])
    assert isinstance(robot.body, NodalBody)
    return robot


def test_a_rod_pushes_where_a_cable_is_slack() -> None:
    pushed, slack = Simulator(built(), "none"), Simulator(built(min_tension=0.0), "none")
    for simulator in (pushed, slack):
        assert simulator.settle(position=[-1e-3], tolerance=1e-9).converged
    assert slack.effort == pytest.approx([0.0], abs=1e-12)
    assert pushed.effort[0] < -0.1
    assert pushed.position == pytest.approx([-1e-3], abs=1e-9)
    assert pushed.effector[0, 2] > slack.effector[0, 2] + 1e-3  # it lifts the end above it


def test_it_pushes_as_hard_as_it_pulls_for_small_strokes() -> None:
    simulator, effort = Simulator(built(), "none"), []
    for position in (1e-5, -1e-5):
        assert simulator.settle(position=[position], tolerance=1e-12).converged
        effort.append(simulator.effort[0])
    assert effort[1] == pytest.approx(-effort[0], rel=5e-3)


@pytest.mark.parametrize("effort", [6.0, -6.0])
def test_the_tangent_is_the_derivative_of_all_forces(effort: float) -> None:
    robot = built()
    rest, rng, step = robot.rest(), np.random.default_rng(0), 1e-6
    state = State(rest.q + 3e-4 * rng.standard_normal(robot.n), rest.v)
    direction, lam = rng.standard_normal(robot.n), np.array([effort])

    def force(by: float) -> Array:
        moved = State(state.q + by * direction, state.v)
        total: Array = robot.forces(moved)[0]
        return total + robot.rows(moved, contacts=False).actuators.H.T @ lam

    matrices = [
        sp.csc_array(
            (
                robot.forces(state, lam, exact)[1],
                robot.body.pattern.indices,
                robot.body.pattern.indptr,
            )
        )
        for exact in (True, False)
    ]
    change = -(force(step) - force(-step)) / (2.0 * step)
    np.testing.assert_allclose(matrices[0] @ direction, change, atol=1e-6 * np.abs(change).max())
    if effort < 0.0:  # the other one stays positive definite, as without the rod
        assert np.linalg.eigvalsh(matrices[1].toarray()).min() > 0.0


def test_the_inverse_pushes() -> None:
    """A target above the end, on the side of the rod that pulling leads away from."""
    simulator = Simulator(built(), "none")
    assert simulator.settle(position=[-1e-3]).converged
    errors = []
    for least in (-20.0, 0.0):
        controller = Controller(
            built(min_tension=least), settings=ControllerSettings(regularisation=1e-8)
        )
        for _ in range(60):
            actuation = controller.step(simulator.effector[0])
            assert actuation.status is Status.OK
        errors.append(float(np.linalg.norm(controller.effector[0] - simulator.effector[0])))
    assert errors[0] < 0.05 * errors[1]


def test_the_winch_of_a_drum_holds_no_rod() -> None:
    spring = {"stiffness": 500.0}
    drum = {"name": "drum", "kind": "drum", "members": ["tendon"], "gains": [1.0],
            "max_position": 0.02, "max_effort": 5.0, "max_rate": 0.1}  # fmt: skip
    for least, good in ((0.0, True), (-1.0, False)):
        settings = pneumatic_config(
            chambers=[],
            cables=[{**CABLE, "spring": spring, "min_tension": least}],
            couplings=[drum],
        )
        if good:
            validated(RobotConfig, settings, "robot.toml")
            continue
        with pytest.raises(RobotFileError, match=r"on a drum .* with a min_tension of 0 or more"):
            validated(RobotConfig, settings, "robot.toml")
