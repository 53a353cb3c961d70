"""Quasi-static robots whose winches cross their range in a tick, beside equilibria at all positions."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import beam_robot, box_mesh
from support.robots.small_bodies import SLIDE, constrained
from support.state_bases import basis_of

from tauten.controller import Controller, Status
from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.reduction.state import reduced_robot, reducible

SIZE = (0.1, 0.02, 0.02)
PULL = 0.03  # m
AWAY = np.array(
    [[0.0, 0.0, 0.0], [0.003, 0.0, -0.004], [-0.01, 0.0, 0.01]]
)  # m, from where the tip gets to


@pytest.fixture(scope="module", params=["corotational", "neo-hookean"])
def beam(request: pytest.FixtureRequest) -> Robot:
    """One cable, whose winch winds all of it in a period."""
    cable = {
        "name": "tendon", "points": [[0.01, 0.01, 0.002], [0.05, 0.01, 0.002], [0.1, 0.01, 0.002]],
        "max_tension": 100.0, "max_pull": PULL, "max_rate": 50.0 * PULL,
    }  # fmt: skip
    return beam_robot(
        box_mesh(SIZE, (8, 2, 2)), SIZE, cables=[cable], integration={"scheme": "quasi-static"},
        material={"law": request.param, "young_modulus": 1e5, "poisson_ratio": 0.4, "density": 1e3},
        controller={"rate": 50.0},
    )  # fmt: skip


@pytest.fixture(scope="module")
def tips(beam: Robot) -> Array:
    """The tip in equilibrium at evenly spaced positions of the winch: (61, 3) [m]."""
    simulator, found = Simulator(beam, "none"), []
    for position in np.linspace(0.0, PULL, 61):
        assert simulator.settle(position=[position]).converged
        found.append(simulator.effector[0])
    return np.array(found)


def nearest(tips: Array, goal: Array) -> float:
    """Distance of a goal from the line through some tips [m]."""
    start, way = tips[:-1], np.diff(tips, axis=0)
    share = np.clip(np.einsum("ij,ij->i", goal - start, way) / np.sum(way**2, axis=1), 0.0, 1.0)
    return float(np.linalg.norm(start + share[:, None] * way - goal, axis=1).min())


@pytest.mark.long
@pytest.mark.parametrize("place", [12, 30, 54])
@pytest.mark.parametrize("away", AWAY, ids=str)
def test_it_rests_at_the_best_place(beam: Robot, tips: Array, place: int, away: Array) -> None:
    """After one linearisation for all of the range neo-Hookean elements were turned inside out."""
    goal = tips[place] + away
    controller = Controller(beam)
    assert controller.settle_start().converged
    for _ in range(40):
        assert controller.step(goal).status is Status.OK
    best = nearest(tips, goal)
    assert np.linalg.norm(controller.effector[0] - goal) < best + 1e-4
    simulator = Simulator(beam, "none")
    assert simulator.settle(position=controller.position).converged
    assert controller.effector == pytest.approx(simulator.effector, abs=1e-6)


def test_one_move_through_all_of_the_range_ends_in_equilibrium(beam: Robot, tips: Array) -> None:
    simulator = Simulator(beam, "none")
    assert simulator.settle_start().converged
    assert simulator.move(position=[PULL]).converged
    assert simulator.effector[0] == pytest.approx(tips[-1], abs=1e-6)


@pytest.mark.parametrize("reduced", [False, True], ids=["full", "reduced"])
@pytest.mark.parametrize("turned", [0.35, 0.65])
def test_a_slider_that_carries_a_soft_beam_bears_its_weight_and_brings_it_to_targets(
    turned: float, reduced: bool
) -> None:
    """The slider has no stiffness of its own: the whole beam goes along, as far as any force wants.

    So its tangent is singular, and factors of it are those of rounding.
    """
    cable = {"max_tension": 60.0, "min_pull": -0.05, "max_pull": 0.05, "max_rate": 10.0}
    sides = {"lower": (0.01, 0.002), "upper": (0.01, 0.018), "right": (0.018, 0.01)}
    cables = [
        {"name": name, "points": [[0.01, y, z], [0.1, y, z]], **cable}
        for name, (y, z) in sides.items()
    ]
    root, end = (
        {"lower": [0.0] * 3, "upper": [0.0, 0.02, 0.02]},
        {"lower": [0.095, -1, -1], "upper": [1.0] * 3},
    )
    slider = {**SLIDE, "region": root, "min_travel": -0.02, "max_travel": 0.02, "max_force": 50.0}
    robot = constrained(
        box_mesh(SIZE, (5, 1, 1)), fixed=[], drives=[slider], cables=cables, gravity=[0.0, 0.0, -9.81],
        effectors=[{"name": "tool", "kind": "frame", "region": end}],
        integration={"scheme": "quasi-static"}, controller={"rate": 50.0},
    )  # fmt: skip
    weight = 9.81 * robot.body.tetrahedra.mass.reshape(-1, 3)[:, 0].sum()
    if reduced:  # to as many modes as it has unknowns, with every element
        Phi = np.diag(np.append(1.0 / np.sqrt(reducible(robot).weight[:-1]), 1.0))
        every = np.arange(robot.body.n_elements)
        robot = reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))
    there, controller = Simulator(robot, "none"), Controller(robot)
    assert there.settle(position=[turned * 0.03, 0.005, turned * 0.015, 0.006]).converged
    assert controller.settle_start().converged
    for _ in range(30):
        actuation = controller.step(there.effector_values)
        assert actuation.status is Status.OK
        assert actuation.effort[-1] == pytest.approx(weight, rel=1e-6)
    layout = robot.effector_layout
    assert layout.error(controller.effector_values, there.effector_values) < 1e-4
    simulator = Simulator(robot, "none")
    for position in (0.0, 0.005):
        simulator.step(position=[0.0, 0.0, 0.0, position])
        assert simulator.effort[-1] == pytest.approx(weight, rel=1e-6)
