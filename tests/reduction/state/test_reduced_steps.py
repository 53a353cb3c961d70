"""Energies and converged steps of reduced robots: derivatives, the full robot, energy that never grows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.bodies import CABLE
from support.robots.combinations import robot_with, write_networks
from support.robots.short_arm import short_arm
from support.robots.small_bodies import (
    FIRST,
    GLUE,
    HINGE,
    LAST,
    MESH,
    MIDDLE,
    RUBBER,
    SECOND,
    SLIDE,
    TURN,
    WINCH,
    constrained,
    small_body,
)
from support.state_bases import basis_of, projected, turned_space

from tauten.model import Integration, Robot, Simulator, State
from tauten.model.numerics import Array
from tauten.reduction.state import ReducedBody, reduced_robot, reducible

KINDS = (
    "linear, regions",
    "smoothed, mixed laws",
    pytest.param("quadratic, mooney-rivlin", marks=pytest.mark.slow),
)


def with_modes(robot: Robot, modes: int, weights: Array | None = None) -> Robot[ReducedBody]:
    """Random modes, and every element with the given weights or one."""
    body = reducible(robot)
    own, weight = body.own_coordinates, body.weight
    inner = len(weight) - own
    Phi = np.zeros((len(weight), modes + own))
    random = np.random.default_rng(0).normal(size=(inner, modes))
    Phi[:inner, :modes] = np.linalg.qr(random)[0] / np.sqrt(weight[:inner, None])
    Phi[inner:, modes:] = np.eye(own)
    every = np.arange(body.n_elements)
    given = np.ones(len(every)) if weights is None else weights
    return reduced_robot(robot, basis_of(robot, Phi, every, given))


def driven(_: Path) -> Robot[ReducedBody]:
    """Two boxes, glued: a slider, a servo and a hinge, a cable on a preloaded winch."""
    robot = constrained(
        [MESH, MESH], bodies=[FIRST, SECOND], mesh=None, fixed=[], material=RUBBER,
        gravity=[0.0, 0.0, -9.81], attachments=[GLUE, HINGE], cables=[CABLE],
        drives=[{**SLIDE, "region": LAST}, {**TURN, "region": MIDDLE}], couplings=[WINCH],
        controller={"rate": 200.0},
    )  # fmt: skip
    return with_modes(robot, 9)


def sampled(_: Path) -> Robot[ReducedBody]:
    """A body of two laws, with random modes, and weights that are no quadrature."""
    robot = small_body("smoothed, mixed laws", controller={"rate": 200.0})
    count = reducible(robot).n_elements
    weights = np.random.default_rng(1).uniform(0.5, 1.5, count)
    return with_modes(robot, 9, weights)


def arm(folder: Path) -> Robot[ReducedBody]:
    """An arm of beams with a few modes of strain."""
    return with_modes(short_arm(folder), 6)


ROBOTS = [driven, sampled, arm]


@pytest.fixture(params=ROBOTS, ids=lambda make: make.__name__)
def reduced(request: pytest.FixtureRequest, tmp_path: Path) -> Robot[ReducedBody]:
    make: Callable[[Path], Robot[ReducedBody]] = request.param
    return make(tmp_path)


def shaken(robot: Robot[ReducedBody], far: float, speed: float) -> State:
    """A state in motion."""
    q, v = np.random.default_rng(2).normal(size=(2, robot.n))
    scale = np.abs(robot.displacement(robot.rest(), q))
    return State(far / scale * q, speed / scale * v)


@pytest.mark.parametrize("kind", KINDS)
def test_the_potential_of_all_modes_is_that_of_the_full_robot(kind: str) -> None:
    body = small_body(kind, gravity=[0.0, 0.0, -9.81])
    every = np.arange(reducible(body).n_elements)
    reduced = reduced_robot(body, basis_of(body, turned_space(body), every, np.ones(len(every))))
    q = body.rest().q + 5e-4 * np.random.default_rng(3).normal(size=body.n)
    state = State(q, np.random.default_rng(4).normal(size=body.n))
    found = projected(reduced, state)
    assert reduced.potential(found) == pytest.approx(body.potential(state), rel=1e-9)
    assert reduced.body.kinetic_energy(found) == pytest.approx(
        body.body.kinetic_energy(state), rel=1e-9
    )
    assert reduced.potential(reduced.rest()) == pytest.approx(0.0, abs=1e-12)


def test_forces_are_the_derivative_of_the_potential(reduced: Robot[ReducedBody]) -> None:
    state, rng = shaken(reduced, 0.01, 0.0), np.random.default_rng(5)
    force, _ = reduced.forces(state)
    for _ in range(3):
        d = 1e-4 * np.abs(state.q).max() * rng.normal(size=reduced.n)
        near, behind, far, beyond = (
            reduced.potential(State(state.q + times * d, state.v))
            for times in (1.0, -1.0, 2.0, -2.0)
        )
        slope = (8.0 * (near - behind) - (far - beyond)) / 12.0  # along d, of fourth order
        assert -force @ d == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_steps_with_all_modes_are_those_of_the_full_robot(kind: str) -> None:
    """Also the end of converged steps, and the energy there, to the tolerance of a step."""
    body = small_body(kind, controller={"rate": 50.0}, integration={"rayleigh_stiffness": 2e-3})
    every = np.arange(reducible(body).n_elements)
    reduced = reduced_robot(body, basis_of(body, turned_space(body), every, np.ones(len(every))))
    ends = []
    for robot in (body, reduced):
        simulator = Simulator(robot, contact="none")
        for _ in range(5):
            assert simulator.step(effort=[5.0], converged=True).converged
        ends.append((simulator.effector, robot.energy(simulator.state)))
    assert np.abs(ends[0][0] - body.effector(body.rest())).max() > 2e-3
    np.testing.assert_allclose(ends[1][0], ends[0][0], atol=1e-7)
    assert ends[1][1] == pytest.approx(ends[0][1], rel=1e-5)


def test_energy_never_grows_without_work(reduced: Robot[ReducedBody]) -> None:
    """Actuators without effort, from wild motion."""
    simulator, start = Simulator(reduced, contact="none"), shaken(reduced, 0.0, 1.0)
    simulator.start_from(start)
    energies = [reduced.energy(start)]
    for _ in range(30):
        assert simulator.step(effort=np.zeros(reduced.n_a), converged=True).converged
        energies.append(reduced.energy(simulator.state))
    assert np.diff(energies).max() < 1e-12 * np.abs(energies).max(), "beyond rounding"
    assert energies[-1] < energies[0]


def test_the_balance_of_a_step_is_the_derivative_of_its_potential(
    reduced: Robot[ReducedBody],
) -> None:
    """Differences of Φ at an iterate away from the start are what an iteration has out of balance."""
    scheme = replace(reduced.integration, rayleigh_mass=3.0, rayleigh_stiffness=1e-3)
    robot, rng = reduced.with_integration(scheme), np.random.default_rng(6)
    start = robot.body.step_start(shaken(robot, 0.0, 0.5))
    at = shaken(robot, 0.005, 0.0)
    system = robot.body.linearise_iterate(at, start, np.zeros(robot.n_a))

    def potential(q: Array) -> float:
        state = State(q, at.v)
        return robot.body.step_energy(
            start, robot.body.velocity(start.state, state)
        ) + robot.potential(state)

    for _ in range(3):
        e = rng.standard_normal(robot.n)
        d = system.solve(e[:, None])[:, 0]  # so that d · balance = e · A⁻¹ balance
        scale = 1e-4 * np.abs(at.q).max() / np.abs(d).max()
        near, behind, far, beyond = (
            potential(at.q + times * scale * d) for times in (1.0, -1.0, 2.0, -2.0)
        )
        slope = (8.0 * (near - behind) - (far - beyond)) / (12.0 * scale)  # of fourth order
        assert -system.v_free @ e / robot.h == pytest.approx(slope, rel=1e-5)


@pytest.mark.parametrize("ahead", [0.0, 0.4, 1.0])
def test_a_step_with_a_hinge_solves_its_equation(ahead: float, tmp_path: Path) -> None:
    """A dv = h (f − C v − (1 − ahead) h K v), where the springs of the hinge are damped too."""
    write_networks(tmp_path)
    robot = robot_with([("map", "hinge"), ("reduction", "state basis")], tmp_path)
    body, scheme = robot.body, Integration(200.0, False, 0.7, 0.004, ahead=ahead)
    u, v = np.random.default_rng(0).normal(size=(2, robot.n))
    moved = robot.advance(
        robot.rest(), 1e-3 * robot.size / robot.displacement(robot.rest(), u) * u, 1.0
    )
    state = State(moved.q, v)
    system, (force, K) = robot.linearise(state, None, scheme), robot.forces(state, exact=True)
    inertia, (_, C) = body.inertia_at(state), body.damping_at(state, scheme)
    assert system.exact
    assert inertia is not None
    M, h = body.masses(state), scheme.h
    C = C + 0.7 * M
    left = (M + h * C + h * h * K) @ (system.v_free - (1.0 - ahead) * v)
    right = h * (force + inertia - C @ v - (1.0 - ahead) * h * (K @ v))
    np.testing.assert_allclose(left, right, atol=1e-8 * np.abs(right).max())
