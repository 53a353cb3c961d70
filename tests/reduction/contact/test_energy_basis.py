"""Modes of least contact energy, and the contact problems they are measured on."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from support.robots.thumb import thumb_mesh, thumb_settings

from tauten.model import Robot, Simulator
from tauten.model.contact import ContactSet
from tauten.model.load import build_robot
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Design, Run, Snapshots, run_campaign
from tauten.reduction.contact import (
    ContactProblem,
    contact_problems,
    energy_error,
    fit_each,
    quality,
    refine,
)

Problems = tuple[ContactProblem, ...]


def random_problem(rng: np.random.Generator, n_c: int, column: int) -> ContactProblem:
    """Springs with gaps to close, W of full rank, some candidates out of range."""
    slots = np.sort(rng.choice(n_c, size=rng.integers(2, n_c + 1), replace=False))
    root = rng.normal(size=(len(slots), len(slots)))
    W = root @ root.T + 0.1 * np.eye(len(slots))
    lam = rng.random(len(slots)) * (rng.random(len(slots)) < 0.7)
    lam[0] += 0.1
    delta = (
        np.where(lam > 0.0, 0.0, rng.random(len(slots))) - W @ lam
    )  # gaps close where lam pushes
    energy = -float(0.5 * lam @ W @ lam + delta @ lam)
    return ContactProblem(W, rng.normal(size=(3, len(slots))), delta, slots, lam, energy, column)


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(1, 6))
@example(seed=477029, k=6)  # a mode that shrinks to nothing in one problem
def test_descent_never_ascends_and_keeps_a_basis(seed: int, k: int) -> None:
    rng = np.random.default_rng(seed)
    problems = [random_problem(rng, 8, column) for column in range(6)]
    start = rng.random((8, k)) + 1e-3
    Psi, history = refine(start, problems)
    assert (Psi >= 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(Psi, axis=0), 1.0, rtol=1e-12)
    assert (np.diff(history) <= 0.0).all()
    assert 0.0 <= history[-1] <= history[0] <= 1.0 + 1e-12
    np.testing.assert_allclose(history[-1], energy_error(Psi, problems), atol=1e-7)


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(1, 4))
def test_order_of_problems_does_not_matter(seed: int, k: int) -> None:
    rng = np.random.default_rng(seed)
    problems = [random_problem(rng, 8, column) for column in range(6)]
    start = rng.random((8, k)) + 1e-3
    (one, history), (other, again) = (
        refine(start, order, max_sweeps=3)
        for order in (problems, [problems[i] for i in rng.permutation(6)])
    )
    np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(history, again)


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 2**32 - 1))
def test_forces_themselves_lose_nothing(seed: int) -> None:
    """A basis that holds the forces of every problem is exact, and so is the whole of them."""
    rng = np.random.default_rng(seed)
    problems = [random_problem(rng, 8, column) for column in range(4)]
    forces = np.zeros((8, 4))
    for problem in problems:
        forces[problem.slots, problem.column] = problem.lam
    for Psi in (forces / np.linalg.norm(forces, axis=0), np.eye(8)):
        found = quality(Psi, problems)
        assert found.energy < 1e-6
        assert max(found.force, found.tip) < 1e-6


@pytest.mark.long
@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 2**32 - 1))
@example(seed=0)
def test_more_modes_never_lose_more_energy(seed: int) -> None:
    """Descent from the start of 4 modes alone may end above what 3 reached."""
    rng = np.random.default_rng(seed)
    problems = [random_problem(rng, 8, column) for column in range(6)]
    S = np.zeros((8, 6))
    for problem in problems:
        S[problem.slots, problem.column] = problem.lam
    rank = int(np.linalg.matrix_rank(S))
    fits = fit_each(S, problems, range(1, rank + 1))
    lost = [energy_error(fit.Psi, problems) for fit in fits]
    assert (np.diff(lost) <= 1e-7).all()
    assert [fit.k for fit in fits] == list(range(1, rank + 1))


def test_problems_are_the_equilibria(
    thumb: Robot, thumb_ramp: Snapshots, thumb_problems: Problems
) -> None:
    """Their forces hold the cable at the tension of the equilibrium and move nothing further."""
    assert len(thumb_problems) == np.count_nonzero(thumb_ramp.lam.any(axis=0))
    largest = thumb_ramp.lam.sum(axis=0).max()
    for problem in thumb_problems:
        total = thumb_ramp.lam[:, problem.column].sum()
        assert abs(problem.lam.sum() - total) < 1e-3 * largest
        gaps = problem.delta + problem.W @ problem.lam
        assert gaps.min() > -1e-9
        assert problem.energy > 0.0
    few = contact_problems(thumb, thumb_ramp, count=5)
    assert len(few) == 5
    old = thumb.contacts
    rubbing = [replace(pair, friction=0.3) for pair in old.pairs]
    contacts = ContactSet(rubbing, old.n_vertices, old.alarm_distance, old.distance)
    with_friction = contact_problems(replace(thumb, contacts=contacts), thumb_ramp, count=5)
    for problem, same in zip(few, with_friction, strict=True):  # bases are of normal forces
        np.testing.assert_allclose(same.W, problem.W, rtol=1e-9)
        # rounding of W moves forces between candidates that are near each other, and no gap
        gaps = [one.delta + one.W @ one.lam for one in (same, problem)]
        np.testing.assert_allclose(*gaps, atol=1e-10)
        np.testing.assert_allclose(same.lam, problem.lam, atol=1e-4 * largest)


def test_first_order_effector_error_is_what_the_simulator_finds(
    thumb: Robot, thumb_ramp: Snapshots, thumb_problems: Problems
) -> None:
    """Without any contact mode the tip error of light contact is that of passing through."""
    problem = thumb_problems[0]
    nothing = np.zeros(len(problem.slots))
    simulator = Simulator(thumb, contact="none")
    simulator.settle(position=thumb_ramp.position[:, problem.column])
    apart = simulator.effector.ravel() - thumb_ramp.effector[:, problem.column]
    np.testing.assert_allclose(problem.tip_error(nothing), np.linalg.norm(apart), rtol=0.1)


SPRING = {"stiffness": 2e3, "pretension": 0.5}
PUSH = {
    "name": "push", "point": [0.0075, 0.0075, -0.05], "direction": [-1.0, 0.0, 0.0],
    "max_force": 5.0, "max_travel": 0.05, "max_rate": 0.1, "held": "force",
}  # fmt: skip


def thumb_with(**changes: object) -> Robot[NodalBody]:
    """The thumb with other actuators, without gravity."""
    config = RobotConfig.model_validate({**thumb_settings(), "gravity": [0.0, 0.0, 0.0], **changes})
    robot = build_robot(config, thumb_mesh(), "thumb")
    assert isinstance(robot.body, NodalBody)
    return robot


def equilibria(robot: Robot, run: Run, folder: Path) -> Snapshots:
    """Those of one run."""
    found = run_campaign(robot, Design("one", (run,)), folder)
    assert found.converged.all()
    return found


def run_of(position: Array, effort: Array | None) -> Run:
    """A run without loads: positions (1, s), or efforts (1, s)."""
    s = position.shape[1]
    return Run(position, np.zeros((3, s)), np.zeros((3, s)), effort)


def check_problems(robot: Robot, found: Snapshots, as_held: bool) -> None:
    """Forces of the equilibria, and where the tip goes without contact while the actuator is held alike."""
    problems = contact_problems(robot, found, as_held=as_held)
    assert len(problems) >= 2
    for problem in problems:
        total = found.lam[:, problem.column].sum()
        assert problem.lam.sum() == pytest.approx(total, rel=5e-3)
    light = problems[1]
    simulator = Simulator(robot, contact="none")
    position, effort = found.position[:, light.column], found.effort[:, light.column]
    command = robot.actuators.laws.held(position, effort)
    report = (
        simulator.settle(command.position, command.effort)
        if as_held
        else simulator.settle(position)
    )
    assert report.converged
    apart = float(np.linalg.norm(simulator.effector.ravel() - found.effector[:, light.column]))
    assert light.tip_error(np.zeros(len(light.slots))) == pytest.approx(apart, rel=0.1)


def test_a_spring_before_the_cable_is_part_of_the_problem(tmp_path: Path) -> None:
    """Its winch is held, not the cable."""
    cable = {**thumb_settings()["cables"][0], "spring": SPRING, "max_pull": 0.02}
    robot = thumb_with(cables=[cable])
    found = equilibria(robot, run_of(np.linspace(0.0028, 0.0036, 5)[None], None), tmp_path)
    check_problems(robot, found, as_held=False)


@pytest.mark.parametrize("as_held", [False, True])
def test_an_actuator_that_pushes_is_held_at_its_position_or_its_effort(
    tmp_path: Path, as_held: bool
) -> None:
    """Its efforts are negative: they bend the thumb until the notches close."""
    robot = thumb_with(cables=[], forces=[PUSH])
    efforts = -np.linspace(0.3, 0.6, 5)[None]
    found = equilibria(robot, run_of(np.full_like(efforts, np.nan), efforts), tmp_path)
    check_problems(robot, found, as_held)


@pytest.mark.parametrize(("k", "factor"), [(2, 0.8), (4, 0.8), (8, 1.05)])
def test_energy_modes_have_less_energy_error_than_the_factorisation(
    thumb_ramp: Snapshots, thumb_problems: Problems, k: int, factor: float
) -> None:
    """On problems that both have not seen; with many modes the two are alike."""
    S: Array = thumb_ramp.lam
    known = thumb_problems[::2]
    (energy,), (plain,) = (fit_each(S, known, (k,), method) for method in ("energy", "hals"))
    others = thumb_problems[1::2]
    assert quality(energy.Psi, others).energy < factor * quality(plain.Psi, others).energy
