"""Rows against finite differences, and forces that obey Newton's third law."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.model import Robot, Simulator, State
from tauten.model.numerics import Array
from tauten.model.tetra import NodalBody


@pytest.fixture(scope="module")
def bent(finger: Robot[NodalBody]) -> Simulator:
    simulator = Simulator(finger, contact="full")
    for position in (0.010, 0.020, 0.025):
        assert simulator.settle(position=[position], tolerance=1e-6).converged
    return simulator


def central(function, q: Array, d: Array, eps: float = 1e-8) -> Array:  # type: ignore[no-untyped-def]
    difference: Array = (function(q + eps * d) - function(q - eps * d)) / (2 * eps)
    return difference


def test_effector_and_actuator_rows_are_derivatives(
    finger: Robot[NodalBody], bent: Simulator
) -> None:
    q = bent.state.q
    rows = finger.rows(bent.state)
    for seed in range(3):
        d = np.random.default_rng(seed).standard_normal(q.size)
        for name in ("effectors", "actuators"):

            def delta(q: Array, name: str = name) -> Array:
                moved: Array = getattr(finger.rows(State(q, q), contacts=False), name).delta
                return moved

            H = getattr(rows, name).H
            assert np.allclose(H @ d, central(delta, q, d), atol=1e-6 * np.abs(H @ d).max())


def test_contact_rows_are_derivatives(finger: Robot[NodalBody], bent: Simulator) -> None:
    q, contacts = bent.state.q, finger.rows(bent.state).contacts
    assert len(contacts) > 100

    def gaps(q: Array) -> Array:
        return finger.rows(State(q, q)).contacts.found.gaps()[contacts.slots]

    d = np.random.default_rng(0).standard_normal(q.size)
    expected, found = contacts.rows.H @ d, central(gaps, q, d, 1e-9)
    # where the nearest triangle changes within eps the gap has a kink: a few candidates at most
    close = np.isclose(found, expected, atol=1e-4 * np.abs(expected).max())
    assert close.mean() > 0.98


def test_contact_forces_balance(finger: Robot[NodalBody], bent: Simulator) -> None:
    """A contact pushes both sides equally: no net force, no net moment."""
    contacts = finger.rows(bent.state).contacts
    x = finger.body.nodes(bent.state)[finger.body.pattern.dof >= 0]
    for row in range(0, len(contacts), 7):
        force = np.asarray(contacts.rows.H[[row]].todense()).reshape(-1, 3)
        if np.abs(force.sum(axis=0)).max() < 1e-9:  # no fixed node takes part
            assert np.abs(np.cross(x, force).sum(axis=0)).max() < 1e-9
    total = np.asarray((contacts.rows.H.T @ np.ones(len(contacts))).reshape(-1, 3)).sum(axis=0)
    assert np.abs(total).max() < 1e-9  # the finger's notches are far from its fixed face


def test_settled_finger_is_in_balance(finger: Robot[NodalBody], bent: Simulator) -> None:
    """Elastic, gravity, cable and contact forces add up to nothing."""
    rows = finger.rows(bent.state)
    force, _ = finger.forces(bent.state)
    pushing = bent.lam_c[rows.contacts.slots]
    cable = rows.actuators.H.T @ bent.effort
    residual = force + cable + rows.contacts.rows.H.T @ pushing
    assert pushing.sum() > 1.0
    assert np.abs(residual).max() < 1e-3 * np.abs(cable).max()


def test_work_of_the_cable_is_the_energy_stored(finger: Robot[NodalBody]) -> None:
    """Without contact and gravity, ∫ λ dδ_a over a slow pull equals what comes back on release."""

    robot = finger.loaded(np.zeros(3), np.zeros(3))
    positions = np.linspace(0.0, 0.01, 41)
    out, back = [], []
    simulator = Simulator(robot, contact="none")
    for record, path in ((out, positions), (back, positions[::-1])):
        for position in path:
            assert simulator.settle(position=[position], tolerance=1e-9).converged
            record.append(float(simulator.effort[0]))
    assert np.allclose(out, back[::-1], rtol=1e-6, atol=1e-9)
    # tension is the derivative of stored energy: compare with elastic forces along the last step
    work = np.trapezoid(out, positions)
    assert work == pytest.approx(0.5 * out[-1] * positions[-1], rel=0.05)  # nearly linear
