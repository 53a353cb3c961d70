"""Where controller and simulator start: the equilibrium under the loads, or rest where there is none."""

from __future__ import annotations

import inspect
import logging
from pathlib import Path

import numpy as np
import pytest
from support.processes import ROBOT, write_robot

from tauten.controller import Controller, warm_controller
from tauten.model import Robot, Simulator
from tauten.reduction import BasisError
from tauten.service.setup import load_setup

HEAVY = ROBOT.replace("gravity = [0.0, 0.0, 0.0]", "gravity = [0.0, 0.0, -2.0]")
SAG = 1e-4  # m, of the beam's tip at least


@pytest.fixture(scope="module")
def heavy_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_robot(tmp_path_factory.mktemp("heavy"), HEAVY)


@pytest.fixture(scope="module")
def heavy(heavy_file: Path) -> Robot:
    return load_setup(heavy_file).robot


def test_a_settled_controller_sags_and_does_not_move(heavy: Robot) -> None:
    controller = Controller(heavy)
    rest = controller.effector_values
    assert controller.settle_start().converged
    assert controller.settled
    start = controller.effector_values
    assert rest[2] - start[2] > SAG
    for _ in range(5):
        controller.hold()
        controller.advance()
    np.testing.assert_allclose(controller.effector_values, start, atol=1e-7)
    np.testing.assert_array_equal(controller.position, 0.0)
    controller.step(controller.shifted(0.001))
    controller.reset()
    np.testing.assert_array_equal(controller.effector_values, start)


def test_one_call_makes_the_controller_that_a_node_starts(heavy_file: Path) -> None:
    setup = load_setup(heavy_file)
    one, node = Controller.of(heavy_file), warm_controller(setup)
    assert one.settled
    assert one.settings == node.settings
    assert one.period == setup.robot.h
    assert one.tip.shape == (3,)
    target = one.shifted(0.001)
    for _ in range(3):
        done, expected = one.step(target), node.step(target)
        assert done.status.usable
        np.testing.assert_array_equal(done.effort, expected.effort)
    assert done.effort.any()
    np.testing.assert_array_equal(one.tip, node.effector[0])


def test_one_call_makes_the_simulator_of_the_model_that_decides(heavy_file: Path) -> None:
    controller, simulator = Controller.of(heavy_file), Simulator.of(heavy_file)
    np.testing.assert_array_equal(simulator.tip, controller.tip)
    assert simulator.settle(position=np.full(simulator.robot.n_a, 1e-3)).converged
    simulator.reset()
    np.testing.assert_array_equal(simulator.tip, controller.tip)


@pytest.mark.long
def test_simulators_of_a_file_have_its_model_and_contact_unless_others_are_named(
    shipped_finger: Robot, heavy_file: Path
) -> None:
    """The shipped finger: reduced, with a contact basis."""
    small, full = Simulator.of("finger"), Simulator.of("finger", model="full", contact="none")
    assert small.robot.n < full.robot.n
    assert full.robot.n == shipped_finger.n
    for simulator in (small, full):
        simulator.step(position=[0.02])  # so far in one step that walls meet
    assert small.lam_c.any()
    assert not full.lam_c.any()
    with pytest.raises(BasisError, match="no-such-basis"):
        Simulator.of(heavy_file, contact="no-such-basis")


def test_contact_is_pointwise_where_none_is_named() -> None:
    contacts = [
        inspect.signature(one).parameters["contact"].default for one in (Controller, Simulator)
    ]
    assert contacts == ["full", "full"]


def test_controller_and_simulator_settle_alike(heavy: Robot) -> None:
    controller, simulator = Controller(heavy), Simulator(heavy, "none")
    controller.settle_start()
    simulator.settle_start()
    np.testing.assert_array_equal(simulator.effector_values, controller.effector_values)
    np.testing.assert_array_equal(simulator.tip, controller.tip)
    np.testing.assert_array_equal(simulator.effort, controller.effort)
    simulator.step(position=np.full(heavy.n_a, 1e-3))
    simulator.reset()
    np.testing.assert_array_equal(simulator.effector_values, controller.effector_values)


@pytest.mark.long
def test_a_robot_that_does_not_settle_starts_at_rest_and_says_why(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    crushing = ROBOT.replace("gravity = [0.0, 0.0, 0.0]", "gravity = [-1e3, 0.0, 0.0]")
    crushing = crushing.replace("young_modulus = 1e6", "young_modulus = 1e3")
    setup = load_setup(write_robot(tmp_path, crushing))
    with caplog.at_level(logging.WARNING, "tauten.service.setup"):
        controller = warm_controller(setup)
    assert not controller.settled
    np.testing.assert_array_equal(controller.state.q, setup.robot.rest().q)
    assert "starts undeformed and moves at first: it finds no equilibrium" in caplog.text


@pytest.mark.parametrize("kind", [Controller, Simulator])
def test_what_is_no_robot_is_refused_with_what_to_call(
    kind: type[Controller] | type[Simulator],
) -> None:
    name = kind.__name__
    for given in ("finger", Path("finger")):
        found = rf"^{name} takes a Robot, found 'finger': {name}.of\('finger'\) starts from a name or a file$"
        with pytest.raises(TypeError, match=found):
            kind(given)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=rf"^{name} takes a Robot, found NoneType: load_robot"):
        kind(None)  # type: ignore[arg-type]


def test_a_model_that_there_is_not_is_refused(heavy_file: Path) -> None:
    for made in (Controller, Simulator):
        with pytest.raises(ValueError, match="model: found 'nope', expected one of full, reduced"):
            made.of(heavy_file, "nope")  # type: ignore[arg-type]
        with pytest.raises(BasisError, match="no contact basis '3': expected a path ending in"):
            made.of(heavy_file, contact=3)  # type: ignore[arg-type]
