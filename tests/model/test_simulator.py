"""The simulator's arguments and results: one sentence for what is refused, copies for what is returned."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import beam_robot, box_mesh

from tauten.controller import Controller
from tauten.model import Ending, Robot, Simulator, no_forces

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
        ({"position": [0.0], "effort": [0.0]}, "each actuator needs a number in one of them"),
        ({"effort": [-1.0]}, r"effort: found \[-1.0\], expected 1 values from 0 to 1e\+06"),
        ({"effort": [np.nan]}, r"effort: found \[nan\]"),
        ({"effort": [1e300]}, r"effort: found \[1e\+300\]"),
        ({"position": [1e300]}, r"position: found \[1e\+300\], expected 1 values from -1e\+06"),
        ({"position": [0.0, 0.0]}, r"position: found \[0.0, 0.0\], expected 1 values"),
        ({"position": [[0.0]]}, r"position: found \[\[0.0\]\]"),
        ({"position": [10**400]}, "position: not an array of numbers"),
        ({"position": "far"}, "position: not an array of numbers"),
    ],
)
def test_bad_arguments_are_refused(
    beam: Robot, method: str, arguments: dict[str, object], sentence: str
) -> None:
    simulator = Simulator(beam, contact="none")
    with pytest.raises(ValueError, match=sentence):
        getattr(simulator, method)(**arguments)
    np.testing.assert_array_equal(simulator.state.q, beam.rest().q)


@pytest.mark.parametrize(
    ("gravity", "force", "sentence"),
    [
        ([0.0, np.nan, 0.0], [0.0] * 3, r"gravity: found \[0.0, nan, 0.0\], expected 3 values"),
        ([0.0, 0.0], [0.0] * 3, r"gravity: found \[0.0, 0.0\], expected 3 values"),
        ([0.0] * 3, [0.0] * 6, "effector_force: found .*, expected 3 values from -1e"),
        ([0.0] * 3, [0.0, np.inf, 0.0], "effector_force: found .*, one for each axis of each"),
        ("down", [0.0] * 3, "gravity: not an array of numbers"),
    ],
)
def test_loads_that_are_none_are_refused(
    beam: Robot, gravity: list[float], force: list[float], sentence: str
) -> None:
    """They became the robot's: its next step was NaN, and the report said that it had converged."""
    simulator = Simulator(beam, contact="none")
    with pytest.raises(ValueError, match=sentence):
        simulator.load(gravity, force)
    simulator.load([0, 0, -9], [0, 0, 1])
    assert simulator.settle(effort=[0.0]).converged
    assert np.isfinite(simulator.state.q).all()


def test_the_state_of_another_robot_is_refused(beam: Robot) -> None:
    other = beam_robot(box_mesh(SIZE, (5, 2, 2)), SIZE)
    with pytest.raises(
        ValueError, match=r"state: found 135 degrees of freedom, expected 162, .*beam"
    ):
        Simulator(beam, contact="none").start_from(other.rest())


def test_what_is_returned_can_be_overwritten_without_effect(beam: Robot) -> None:
    simulator, other = Simulator(beam, contact="none"), Simulator(beam, contact="none")
    for position in (0.001, 0.002, 0.003):
        commanded = np.array([position])
        simulator.step(position=commanded)
        other.step(position=[position])
        state, forces = simulator.state, simulator.forces
        for array in (
            commanded, state.q, state.v, forces.effort, simulator.effector, simulator.effort,
            simulator.position, simulator.gaps, simulator.lam_c,
        ):  # fmt: skip
            array += 1.0
    np.testing.assert_array_equal(simulator.effector, other.effector)
    np.testing.assert_array_equal(simulator.effort, other.effort)


def test_a_start_elsewhere_continues_as_the_other_does(beam: Robot) -> None:
    simulator, other = Simulator(beam, contact="none"), Simulator(beam, contact="none")
    for _ in range(5):
        other.step(position=[0.003])
    state, forces = other.state, other.forces
    simulator.start_from(state, forces)
    for array in (state.q, state.v, forces.effort):
        array += 1.0
    for _ in range(5):
        simulator.step(position=[0.002])
        other.step(position=[0.002])
    np.testing.assert_array_equal(simulator.effector, other.effector)


@pytest.mark.long
@pytest.mark.parametrize("held", [{"effort": [1e6]}, {"position": [1e3]}])
def test_a_load_far_beyond_the_robot_leaves_a_finite_state(
    beam: Robot, held: dict[str, list[float]]
) -> None:
    simulator = Simulator(beam, contact="none")
    report = simulator.settle(**held)
    assert np.isfinite(simulator.state.q).all()
    assert np.isfinite(simulator.effort).all()
    assert report.converged is (report.ending is Ending.SETTLED)
    assert report.converged is (report.share == 1.0)


@pytest.mark.parametrize("method", ["step", "move"])
def test_a_step_to_where_no_robot_can_be_has_not_converged(beam: Robot, method: str) -> None:
    """A bar of 10 cm whose cable is pulled by 10 m; a pull of 4 mm in one step is what it follows."""
    simulator = Simulator(beam, contact="none")
    assert getattr(simulator, method)(position=[0.004]).converged
    simulator.reset()
    report = getattr(simulator, method)(position=[10.0])
    assert not report.converged
    assert report.ending in (Ending.NOT_FINITE, Ending.INVERTED, Ending.LIMIT_POINT)


@pytest.mark.parametrize("given", [0, 2.5, np.nan, "two", None])
def test_numbers_of_steps_that_are_none_are_refused(beam: Robot, given: object) -> None:
    """NaN was silently no iteration at all."""
    simulator = Simulator(beam, contact="none")
    sentence = r"found .*, expected a whole number of at least 1"
    with pytest.raises(ValueError, match=f"steps: {sentence}"):
        simulator.move(effort=[0.0], steps=given)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=f"max_iterations: {sentence}"):
        simulator.settle(effort=[0.0], max_iterations=given)  # type: ignore[arg-type]
    if given not in (2.5, None):  # without one, it is by the size of the robot
        with pytest.raises(ValueError, match=r"tolerance: found .*, expected a positive number"):
            simulator.settle(effort=[0.0], tolerance=given)  # type: ignore[arg-type]


def test_a_tolerance_of_several_numbers_is_refused(beam: Robot) -> None:
    """It was a TypeError of NumPy."""
    with pytest.raises(ValueError, match=r"tolerance: found \[1. 2.\], expected a positive number"):
        Simulator(beam, "none").settle(effort=[0.0], tolerance=np.array([1.0, 2.0]))  # type: ignore[arg-type]


def test_what_is_of_another_kind_is_one_sentence(beam: Robot) -> None:
    simulator = Simulator(beam, contact="none")
    with pytest.raises(TypeError, match=r"^state: expected State, found list$"):
        simulator.start_from([0.0])  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"^forces: expected Forces, found list$"):
        simulator.start_from(simulator.state, [0.0])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"forces: found 2 efforts and 0 coefficients .* 1 and 0"):
        simulator.start_from(simulator.state, no_forces(2, 0))
    for kind in (Simulator, Controller):
        with pytest.raises(
            ValueError, match=r'contact is 3, allowed are "none", "full" or a basis'
        ):
            kind(beam, 3)  # type: ignore[arg-type]
        with pytest.raises(TypeError, match=r"^enrichment: expected Enrichment, found int$"):
            kind(beam, "full", 3)  # type: ignore[arg-type]
        with pytest.raises(
            TypeError, match=r"^expected the name of a shipped robot .*, found Robot"
        ):
            kind.of(beam)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"^settings: expected ControllerSettings, found dict$"):
        Controller(beam, settings={})  # type: ignore[arg-type]
