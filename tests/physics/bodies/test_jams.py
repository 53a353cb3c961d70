"""What obstacles squeeze beyond what it can yield: the status says so, and how deep it is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.robots.blocks import box, free_bodies, plane, touching

from tauten.controller import Controller, Status
from tauten.model import Robot, Simulator
from tauten.service.node import ControlLoop, Signals
from tauten.service.wire import Cause, Mode

EDGE, RATE = 0.02, 100.0


def plates(shape: str) -> list[dict[str, Any]]:
    """A floor, and what comes down on it; boxes are as thick as the cube."""
    if shape == "plane":
        low = plane("floor", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        return [low, plane("top", (0.0, 0.0, EDGE), (0.0, 0.0, -1.0))]
    below = {"lower": [-0.1, -0.1, -EDGE], "upper": [0.1, 0.1, 0.0]}
    above = {"lower": [-0.1, -0.1, 0.0], "upper": [0.1, 0.1, EDGE]}
    return [
        {"name": "floor", "shape": "box", "parameters": below},
        {"name": "top", "shape": "box", "parameters": above, "position": [0.0, 0.0, EDGE]},
    ]


def squeezed(rigid: bool, friction: float, shape: str = "plane") -> Robot:
    """A cube between two plates, or planes."""
    contacts = [touching("cube", name, friction=friction) for name in ("floor", "top")]
    cube = {"cube": box((EDGE, EDGE, EDGE), (0.0, 0.0, 0.0))}
    return free_bodies(cube, contacts, RATE, rigid, obstacles=plates(shape))


def depth(model: Simulator | Controller) -> float:
    """How deep the cube is in either plane [m]."""
    z, top = model.robot.candidates(model.state)[:, 2], model.obstacles.poses[1].position[2]
    return float(max(-z.min(), z.max() - top))


@pytest.mark.long
@pytest.mark.parametrize(  # speeds [m/s]; any two of the three in all combinations
    ("speed", "how", "friction"),
    [
        (speed, how, 0.5 * ((i + k) % 2))
        for i, speed in enumerate((0.001, 0.1, 1.0))
        for k, how in enumerate(("move", "step", "converged"))
    ],
)
def test_a_rigid_cube_between_closing_planes_is_in_them_by_half_of_what_they_close(
    speed: float, how: str, friction: float
) -> None:
    """No step has a solution, none is called converged, and the report has the depth."""
    simulator = Simulator(squeezed(True, friction))
    simulator.place("top", [0.0, 0.0, EDGE], velocity=[0.0, 0.0, -speed])
    for number in range(1, 5):
        if how == "move":
            report = simulator.move(effort=[0.0])
        else:
            report = simulator.step(effort=[0.0], converged=how == "converged")
        least = 0.5 * number * speed / RATE
        assert not report.converged
        assert least * (1.0 - 1e-3) < depth(simulator) < 1.6 * least
        assert report.deepest_gap == pytest.approx(-depth(simulator), rel=0.1)


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_soft_cube_stays_between_plates_that_close_by_half_of_their_thickness_in_a_step(
    friction: float,
) -> None:
    """Halfway through a plate both of its sides are as near; the upper one would let the cube out."""
    simulator = Simulator(squeezed(False, friction, "box"))
    simulator.place("top", [0.0, 0.0, EDGE], velocity=[0.0, 0.0, -0.5 * EDGE * RATE])
    simulator.step(effort=[0.0])
    assert depth(simulator) < 1e-6
    forces = simulator.contacts
    push = [forces.force[forces.contacts.pair == pair, 2].sum() for pair in (0, 1)]
    assert push[0] > 0.0 > push[1]


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_decisions_for_a_cube_that_is_jammed_are_infeasible(friction: float) -> None:
    """The actuators hold, and the certificate says how deep the cube is."""
    controller = Controller(squeezed(True, friction))
    controller.place("top", [0.0, 0.0, EDGE], velocity=[0.0, 0.0, -0.1])
    for number in range(1, 5):
        actuation = controller.step(controller.effector_values)
        assert actuation.status is Status.INFEASIBLE
        assert "complementarity" in actuation.conflict
        assert not np.any(actuation.effort)
        assert actuation.certificate.deepest_gap < -0.4 * number * 0.1 / RATE


@pytest.mark.long
def test_a_node_holds_while_a_cube_is_jammed_and_goes_on_when_it_is_free() -> None:
    """The goal is 1 mm away all the time."""
    controller = Controller(squeezed(True, 0.5))
    loop, goal = ControlLoop(controller), controller.effector_values + np.array([1e-3, 0.0, 0.0])
    controller.place("top", [0.0, 0.0, EDGE], velocity=[0.0, 0.0, -0.02])
    for _ in range(3):
        action = loop.tick(goal, Signals(target=True))
        assert (action.mode, action.cause) == (Mode.HOLD, Cause.UNUSABLE)
        assert not action.actuation.effort.any()
        loop.prepare()
    controller.place("top", [0.0, 0.0, 2.0 * EDGE])
    for _ in range(20):
        action = loop.tick(goal, Signals(target=True))
        loop.prepare()
    assert action.mode is Mode.RUN
    assert depth(controller) < 1e-6
