"""Errors of the length of a time step: the same pulled lengths with steps a quarter as long."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model import Robot, Simulator, load_robot
from tauten.model.numerics import Array
from tauten.reduction.state import StateBasisError
from tauten.service.setup import Setup, load_setup

PARTS = 4  # of a step


@dataclass(frozen=True, slots=True)
class StepLengthError:
    """How far an effector is from where shorter steps lead it.

    Attributes:
        steps: kind of the steps.
        rms_mm: distance of the first effector from where steps a quarter as long lead it.
        max_mm: the largest.
    """

    steps: str
    rms_mm: float
    max_mm: float


def step_length_errors(setup: Setup, positions: list[Array]) -> tuple[StepLengthError, ...]:
    """Steps of each kind against steps of the same kind that are a quarter as long, with pointwise contact.

    Args:
        setup: robot; where its model is a reduced one, steps of the full one are left out.
        positions: (n_a,) pulled lengths, one for each step [m].
    """
    name, rate = setup.path, setup.robot.integration.rate
    kinds: list[tuple[str, list[Robot], bool]] = []
    if not setup.states:
        robots = [load_robot(name, rate=part * rate) for part in (1, PARTS)]
        kinds += [("one linearisation", robots, False), ("converged", robots, True)]
    try:
        setups = [
            load_setup(name, rate=part * rate, model="reduced", accept_error=True)
            for part in (1, PARTS)
        ]
        kinds.append(("reduced model", [setup.robot for setup in setups], False))
    except StateBasisError:
        pass  # it has none
    found = []
    for kind, pair, converged in kinds:
        long, short = (
            driven(simulator, positions, converged, parts)
            for simulator, parts in zip(map(settled_simulator, pair), (1, PARTS), strict=True)
        )
        apart = 1e3 * np.linalg.norm(long - short, axis=1)
        rms = float(np.sqrt(np.mean(apart**2)))
        found.append(StepLengthError(kind, rms, float(apart.max())))
    return tuple(found)


def settled_simulator(robot: Robot) -> Simulator:
    """A simulator with pointwise contact that starts settled, as a controller does."""
    simulator = Simulator(robot)
    simulator.settle_start()
    return simulator


def moved_by(simulator: Simulator, positions: list[Array], steps: int) -> Array:
    """First effector (m, 3) [m] after each of some pulled lengths, from its start, in steps of second order.

    Args:
        simulator: the robot.
        positions: (n_a,) pulled lengths [m].
        steps: from one pulled length to the next.
    """
    simulator.reset()
    tips = []
    for position in positions:
        simulator.move(position=position, steps=steps)
        tips.append(simulator.effector[0])
    return np.array(tips)


def driven(simulator: Simulator, positions: list[Array], converged: bool, parts: int = 1) -> Array:
    """First effector (m, 3) [m] after each of some pulled lengths, from its start.

    Args:
        simulator: the robot.
        positions: (n_a,) pulled lengths [m].
        converged: whether steps are iterated.
        parts: steps from one pulled length to the next.
    """
    simulator.reset()
    tips, before = [], np.zeros(simulator.robot.n_a)
    for position in positions:
        for part in range(1, parts + 1):
            share = part / parts
            simulator.step(position=(1.0 - share) * before + share * position, converged=converged)
        before = position
        tips.append(simulator.effector[0])
    return np.array(tips)
