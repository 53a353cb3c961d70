"""Tracking: at rest on itself without bias and chatter from the regularisation; what a tick calls."""

from __future__ import annotations

import gc
import sys
from types import FrameType

import numpy as np
import pytest
from support.robots.examples import shipped_setup

from tauten.controller import Controller, Order, closed_compliance
from tauten.model import Robot, Simulator, one_blas_thread
from tauten.reduction import ContactBasis
from tauten.service.plant import PathSettings, make_path

# 1169 in November 2026, then 578, 461, 500 with augmented tangents, 401, 416 with clusters, 413
MOST_CALLS = 416


def test_closed_compliance_is_that_of_contacts_held() -> None:
    """Forces at the pushing contacts that keep their gaps: found as one bordered system."""
    rng = np.random.default_rng(3)
    J = rng.normal(size=(8, 12))
    W = J @ J.T  # 3 effector rows, 2 cables, 3 contacts
    pushing = np.array([True, False, True])
    held = 5 + np.flatnonzero(pushing)
    expected = np.zeros((3, 2))
    for i in range(2):
        push = -np.linalg.solve(W[np.ix_(held, held)], W[held, 3 + i])
        expected[:, i] = W[:3, 3 + i] + W[:3, held] @ push
    np.testing.assert_allclose(closed_compliance(W, 3, 2, pushing), expected, rtol=1e-6)


def test_closed_compliance_survives_redundant_contacts() -> None:
    rng = np.random.default_rng(4)
    J = rng.normal(size=(5, 9))
    J = np.vstack([J, J[4]])  # the same contact twice
    once, twice = (
        closed_compliance(J[:m] @ J[:m].T, 3, 1, np.ones(m - 4, dtype=bool)) for m in (5, 6)
    )
    np.testing.assert_allclose(once, twice, rtol=1e-6)


@pytest.fixture(scope="module")
def reduced_finger() -> Robot:
    """The model that the shipped finger is served with."""
    return shipped_setup("finger").robot


@pytest.fixture(scope="module")
def closed_tip(reduced_finger: Robot) -> np.ndarray:
    """Where the finger's tip is with its notches closed."""
    simulator = Simulator(reduced_finger, contact="full")
    assert simulator.settle(position=[0.024]).converged
    return simulator.effector[0]


def test_still_target_still_tension(reduced_finger: Robot, closed_tip: np.ndarray) -> None:
    controller = Controller(reduced_finger, ContactBasis.load("finger"))
    start = controller.effector[0]
    for share in np.linspace(0.0, 1.0, 80):
        # the pull that ends there grows roughly along an arc; the way does not matter, the end does
        controller.step(start + (closed_tip - start) * share)
    for _ in range(100):
        controller.step(closed_tip)
    efforts = [controller.step(closed_tip).effort[0] for _ in range(50)]
    assert np.ptp(efforts) < 1e-3 * np.mean(efforts)
    assert np.linalg.norm(controller.effector[0] - closed_tip) < 0.3e-3


@pytest.mark.parametrize("position", [0.021, 0.023, 0.025])
def test_the_shipped_finger_settles_from_rest_where_it_does_in_steps(
    reduced_finger: Robot, position: float
) -> None:
    """Notches are detected while they are open: flanks do not pass each other in a large step."""
    once, stepped = (Simulator(reduced_finger, contact="full") for _ in range(2))
    assert once.settle(position=[position]).converged
    for share in (0.4, 0.6, 0.8, 0.9, 1.0):
        assert stepped.settle(position=[share * position]).converged
    np.testing.assert_allclose(once.effector, stepped.effector, atol=1e-5)
    np.testing.assert_allclose(once.effort, stepped.effort, rtol=1e-3)


def test_a_tick_of_the_reduced_finger_calls_few_python_functions() -> None:
    """Half of its time was once their cost; numba's boxing of results and calls of kernels count too.

    Without those that ask each library with threads: how many of them are loaded depends on earlier tests.
    """
    controller, calls = Controller.of("finger"), 0
    target = controller.effector
    for number in range(12):  # targets that move, as the lead asks for
        controller.step(target + 1e-4 * number * np.array([1.0, 0.3, 0.0]))

    def counted(frame: FrameType, event: str, _argument: object) -> None:
        nonlocal calls
        calls += event == "call" and frame.f_globals.get("__name__") != "threadpoolctl"

    before = sys.getprofile()
    gc.disable()  # a collection calls functions of other libraries
    sys.setprofile(counted)
    try:
        with one_blas_thread():
            controller.step(target)
    finally:
        sys.setprofile(before)
        gc.enable()
    assert controller.robot.n < 100, "of the reduced model"
    assert 100 < calls < MOST_CALLS, calls


@pytest.mark.long
@pytest.mark.parametrize(
    ("model", "seconds", "share", "nearest", "farthest"),
    [
        pytest.param("reduced", 10.0, 0.5, 0.5e-3, 0.35e-3, marks=pytest.mark.slow),
        pytest.param("full", 8.0, 0.5, 0.5e-3, 0.5e-3, marks=pytest.mark.slow),
        ("reduced", 8.0, 0.5, 0.8e-3, 0.45e-3),
        ("full", 8.0, 0.35, 0.5e-3, 0.5e-3),
    ],
)
def test_a_gripper_that_would_buckle_without_its_cables_is_pulled_smoothly(
    model: Order, seconds: float, share: float, nearest: float, farthest: float
) -> None:
    """Over the horizon its exact tangent becomes singular; pulls went to and fro by 0.5 mm a tick.

    Those of the full model went to and fro by 1 mm, as far as their rate permits, and the tip was 3.5 mm from
    its targets (RMS).
    """
    controller = Controller.of("gripper", model=model)
    path = make_path("reach", controller.robot, PathSettings(fraction=0.8, period=1.0))
    rest, ticks = controller.effector_values, round(seconds / controller.period)
    pulls, errors = [], []
    for number in range(round(share * ticks)):  # half of a period: there and half of the way back
        goal = rest.copy()
        goal[:3] = path.at(number / ticks)
        pulls.append(controller.step(goal).position)
        errors.append(np.linalg.norm(controller.effector[0] - goal[:3]))
    assert np.sqrt(np.mean(np.square(errors))) < nearest
    assert np.abs(np.diff(pulls, n=2, axis=0)).max() < farthest


@pytest.mark.long
def test_a_target_that_moves_beyond_the_reach_does_not_shake_the_robot() -> None:
    """It was another target in each tick: all of the way, however plans turned back.

    Tensions of at most 80 N changed by 56 N from tick to tick in the mean, and the tip was accelerated 52
    times as much as the target, which moves at 0.24 m/s and is up to 7 % of the robot's size from the tip.
    """
    controller = Controller.of("manipulator", model="reduced")
    rest, size = controller.effector_values, controller.robot.size
    tensions, beyond = [], []
    for tick in range(200):
        way = [np.sin(0.07 * tick), np.cos(0.05 * tick) - 1.0, 0.5 * np.sin(0.03 * tick)]
        goal = rest + 0.1 * size * np.array(way)
        actuation = controller.step(goal)
        assert actuation.status.ok
        tensions.append(actuation.effort)
        beyond.append(np.linalg.norm(controller.effector[0] - goal) > 0.02 * size)
    changes = np.abs(np.diff(tensions, axis=0)).max(axis=1)[beyond[1:]]
    assert len(changes) > 60
    assert np.mean(changes) < 25.0
