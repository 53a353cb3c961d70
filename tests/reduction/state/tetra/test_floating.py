"""State bases of quasi-static robots beside bodies that nothing holds, which move by their inertia."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.linalg import null_space
from support.robots.joined import joined, push, rod

from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.model.parts import Assembly, Between, Part, Placement, join_parts
from tauten.reduction.state import pod, reducible
from tauten.reduction.state.modes import with_own, without_own

BAR = ((0.1, 0.01, 0.01), (5, 1, 1))
CUBE = ((0.02, 0.02, 0.02), (1, 1, 1))
ROOT = {"body": "soft", "lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.01, 0.01]}
PLACE = {"name": "cube", "position": [0.0, 0.1, 0.0], "free": True}
RATE = 50.0  # Hz


def beside(**changes: Any) -> Robot:
    """A soft bar that is held, and a free cube with an effector of its own."""
    tables = {
        "gravity": [0.0, 0.0, -9.81],
        "controller": {"rate": RATE},
        "forces": [push("push", [0.1, 0.005, 0.005], [0.0, 1.0, 0.0])],
        "effectors": [
            {"name": "tip", "point": [0.1, 0.005, 0.005]},
            {"name": "cube", "kind": "centre", "region": {"kind": "all", "body": "cube"}},
        ],
        **changes,
    }
    cube = {**PLACE, **tables.pop("cube", {})}
    bodies = [{"name": "soft", "fixed": [ROOT]}, cube, *tables.pop("more", [])]
    return joined(bodies, {"soft": BAR, "cube": CUBE}, **tables)


def with_a_wire() -> Robot:
    """The bar with a wire that is clamped with it and pinned into it."""
    axis = [[0.0, 0.005, 0.005], [0.1, 0.005, 0.005]]
    start = {"kind": "sphere", "centre": axis[0], "radius": 1e-6, "body": "rod"}
    inside = {"body": "rod", "kind": "half_space", "point": [1e-4, 0, 0], "normal": [1, 0, 0]}
    pin = {"kind": "pin", "region": inside, "to": {"kind": "all", "body": "soft"}}
    wire = rod("rod", axis, elements=3, fixed=[start])
    return beside(more=[wire], attachments=[pin])


def rigid_cube() -> Robot:
    """A rigid cube, whose frame is a coordinate of the reduced robot."""
    return beside(cube={"rigid": True})


def free_wire() -> Robot:
    """A wire that nothing holds besides, whose nodes are coordinates with rotary inertia."""
    return beside(more=[rod("rod", [[0.0, 0.2, 0.0], [0.1, 0.2, 0.0]], elements=2, free=True)])


def complete(robot: Robot) -> Robot:
    """The robot in all modes, of those that leave the pins of beams where they are."""
    body = reducible(robot)
    count = len(body.weight) - body.own_coordinates
    lifting = body.chart.lifting  # type: ignore[attr-defined]
    modes: Array = np.eye(count)
    if lifting is not None:
        modes = null_space(np.kron(lifting.W.toarray(), np.eye(3)))
    norm = np.linalg.cholesky(modes.T @ (body.weight[:count, None] * modes))
    Phi = np.zeros((len(body.weight), modes.shape[1]))
    Phi[:count] = np.linalg.solve(norm, modes.T).T
    every = np.arange(body.n_elements)
    return body.reduced(with_own(body, Phi), every, np.ones(len(every)))


@pytest.mark.parametrize("make", [beside, with_a_wire, rigid_cube, free_wire])
def test_what_is_free_falls_beside_a_reduced_robot(make: Callable[[], Robot]) -> None:
    """By hand: Σ k g h² after the steps; all else is where the full robot has it."""
    robot = make()
    full, small = Simulator(robot, "none"), Simulator(complete(robot), "none")
    rest, steps = robot.effector(robot.rest()), 4
    for _ in range(steps):
        for simulator in (full, small):
            simulator.step(effort=[0.05])
    fall = 9.81 / RATE**2 * sum(range(1, steps + 1))
    np.testing.assert_allclose(small.effector[1] - rest[1], [0.0, 0.0, -fall], atol=1e-9)
    np.testing.assert_allclose(small.effector, full.effector, atol=1e-9)
    assert np.linalg.norm(small.effector[0] - rest[0]) > 1e-4


@pytest.mark.parametrize("reduced", [False, True])
def test_beside_a_dynamic_part_what_is_held_rests_and_what_is_free_falls(reduced: bool) -> None:
    """In steps of second order. The bar went on at the velocity of its last Newton step, and diverged."""
    robot, none = with_a_wire(), np.zeros(0, dtype=np.int64)
    static = complete(robot) if reduced else robot
    dynamic = beside(integration={"scheme": "implicit-euler"})
    places = (Placement(np.eye(3), np.array([0.0, y, 0.0])) for y in (0.0, 0.5))
    parts = [Part(*each) for each in zip("ab", (static, dynamic), places, strict=True)]
    apart = Between((none, none), ())
    two = join_parts(Assembly("two", "base", "", robot.gravity, 1e-6, 5e-3, 0.0, apart), parts)
    both, alone = Simulator(two, "none"), Simulator(robot, "none")
    for _ in range(4):
        both.move(effort=[0.05, 0.05])
        alone.step(effort=[0.05])
    np.testing.assert_allclose(both.effector[0], alone.effector[0], atol=1e-7)
    fall = 9.81 / 2.0 * (4 / RATE) ** 2
    for cube in (1, 3):
        start = two.effector(two.rest())[cube]
        np.testing.assert_allclose(both.effector[cube] - start, [0.0, 0.0, -fall], atol=1e-9)


def test_elements_are_sampled_of_the_bar_beside_a_rigid_cube() -> None:
    """Entries of the cube's rotation are no motion that has forces: they took all of the sample."""
    robot = rigid_cube()
    body, simulator = reducible(robot), Simulator(robot, "none")
    efforts = np.linspace(0.01, 0.1, 10)
    q = np.empty((len(robot.rest().q), len(efforts)))
    for i, effort in enumerate(efforts):
        simulator.step(effort=[effort])
        q[:, i] = simulator.state.q
    deviations = body.deviations(q)
    Phi = with_own(body, pod(without_own(body, deviations), body.weight, 4).Phi)
    alphas = Phi.T @ (body.weight[:, None] * deviations)
    sample = body.sample(Phi, alphas, 1e-2, 0)
    small = Simulator(body.reduced(Phi, sample.elements, sample.weights), "none")
    for effort in efforts:
        small.step(effort=[effort])
    way = np.linalg.norm(simulator.effector[0] - robot.effector(robot.rest())[0])
    assert way > 1e-3
    assert np.linalg.norm(small.effector[0] - simulator.effector[0]) < 0.02 * way


def test_a_rigid_cube_of_a_reduced_robot_turns_with_the_inertia_of_its_shape() -> None:
    """m a² / 6, where masses at the nodes of its one cell would have m a² / 2."""
    moves, floats = (
        complete(beside(cube={"rigid": True}, integration=one))
        for one in (
            {"scheme": "implicit-euler"},
            {"scheme": "quasi-static"},
        )
    )
    floating = floats.body.floating_mass(floats.rest())
    for M in (moves.body.masses(moves.rest()), floating):
        of_place, of_turn = M[-6:-3, -6:-3], M[-3:, -3:]
        inertia = of_place[0, 0] * CUBE[0][0] ** 2 / 6.0 * np.eye(3)
        np.testing.assert_allclose(of_turn, inertia, atol=1e-15)
