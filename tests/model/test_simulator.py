"""The simulator's arguments and results: one sentence for what is refused, copies for what is returned."""

from __future__ import annotations

import numpy as np
import pytest
from support.bodies import beam_robot, box_mesh

from tauten.model import Ending, Robot, Simulator

SIZE = (0.1, 0.02, 0.02)


@pytest.fixture(scope="module")
def beam() -> Robot:
    """A beam with one cable."""
    return beam_robot(box_mesh(SIZE, (6, 2, 2)), SIZE)


@pytest.mark.parametrize("method", ["step", "settle"])
@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({}, "each actuator needs a number in one of them"),
        ({"pull": [0.0], "tension": [0.0]}, "each actuator needs a number in one of them"),
        ({"tension": [-1.0]}, r"tension: found \[-1.0\], expected 1 values from 0 to 1e\+06"),
        ({"tension": [np.nan]}, r"tension: found \[nan\]"),
        ({"tension": [1e300]}, r"tension: found \[1e\+300\]"),
        ({"pull": [1e300]}, r"pull: found \[1e\+300\], expected 1 values from -1e\+06"),
        ({"pull": [0.0, 0.0]}, r"pull: found \[0.0, 0.0\], expected 1 values"),
        ({"pull": [[0.0]]}, r"pull: found \[\[0.0\]\]"),
        ({"pull": [10**400]}, "pull: not an array of numbers"),
        ({"pull": "far"}, "pull: not an array of numbers"),
    ],
)
def test_bad_arguments_are_refused(
    beam: Robot, method: str, arguments: dict[str, object], sentence: str
) -> None:
    simulator = Simulator(beam, contact="none")
    with pytest.raises(ValueError, match=sentence):
        getattr(simulator, method)(**arguments)
    np.testing.assert_array_equal(simulator.state.q, beam.rest().q)


def test_no_iterations_are_refused(beam: Robot) -> None:
    with pytest.raises(ValueError, match="max_iterations: found 0, expected at least 1"):
        Simulator(beam, contact="none").settle(pull=[0.0], max_iterations=0)


def test_what_is_returned_can_be_overwritten_without_effect(beam: Robot) -> None:
    simulator, other = Simulator(beam, contact="none"), Simulator(beam, contact="none")
    for pull in (0.001, 0.002, 0.003):
        commanded = np.array([pull])
        simulator.step(pull=commanded)
        other.step(pull=[pull])
        state, forces = simulator.state, simulator.forces
        for array in (
            commanded, state.q, state.v, forces.tension, simulator.effector, simulator.tension,
            simulator.pull, simulator.gaps, simulator.lam_c,
        ):  # fmt: skip
            array += 1.0
    np.testing.assert_array_equal(simulator.effector, other.effector)
    np.testing.assert_array_equal(simulator.tension, other.tension)


def test_a_start_elsewhere_continues_as_the_other_does(beam: Robot) -> None:
    simulator, other = Simulator(beam, contact="none"), Simulator(beam, contact="none")
    for _ in range(5):
        other.step(pull=[0.003])
    state, forces = other.state, other.forces
    simulator.start_from(state, forces)
    for array in (state.q, state.v, forces.tension):
        array += 1.0
    for _ in range(5):
        simulator.step(pull=[0.002])
        other.step(pull=[0.002])
    np.testing.assert_array_equal(simulator.effector, other.effector)


@pytest.mark.parametrize("held", [{"tension": [1e6]}, {"pull": [1e3]}])
def test_a_load_far_beyond_the_robot_leaves_a_finite_state(
    beam: Robot, held: dict[str, list[float]]
) -> None:
    simulator = Simulator(beam, contact="none")
    report = simulator.settle(**held)
    assert np.isfinite(simulator.state.q).all()
    assert np.isfinite(simulator.tension).all()
    assert report.converged is (report.ending is Ending.SETTLED)
    assert report.converged is (report.share == 1.0)
