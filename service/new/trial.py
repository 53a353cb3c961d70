"""A robot of a guessed file is tried: how far its actuators move it, and how long a control step takes."""

from __future__ import annotations

from dataclasses import dataclass
from time import thread_time

import numpy as np

from tauten.controller import Controller
from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.service.check import step_seconds
from tauten.service.new.guesses import Guess
from tauten.service.new.part import PartError

HALF = 0.5  # of the largest command, where meshes are compared
# of the guessed pull; a robot that cannot be pulled so far needs a look first
LEAST_SHARE = 1.0 / 16.0
PRESSURE = 0.3  # of Young's modulus; no chamber of a guess gets more
LEAST_PRESSURE = 1.0 / 512.0  # of that
FARTHEST = 0.3  # of the body's length; how far a tip of guessed chambers moves at most
STEPS = 6  # control steps that are timed


@dataclass(frozen=True, slots=True)
class Reached:
    """Where the guessed actuators take a robot; half and all of the way from its start under its weight.

    Attributes:
        effort: largest one half way [N, Pa].
        tip: (3,) where the tip is half way [m].
        moved: distance from where it is at the start [m].
        share: of the guessed command that has an equilibrium.
        command: the largest command: a pull [m], or a pressure [Pa].
        volume: largest change of a chamber's volume at that [m³]; 0 for a cable.
    """

    effort: float
    tip: Array
    moved: float
    share: float
    command: float
    volume: float = 0.0


def settled(robot: Robot, part: str) -> Simulator:
    """The robot in equilibrium under its weight.

    Raises:
        PartError: there is none.
    """
    simulator = Simulator(robot, contact="none")
    if not simulator.settle_start().converged:
        raise PartError(
            f"{part}: the body does not come to rest under its weight, held at the larger end of its longest "
            "side; give a larger --young, or turn the part: gravity is along −z"
        )
    return simulator


def pulled(robot: Robot, guess: Guess, part: str, share: float = 1.0) -> Reached:
    """Pull the guessed cable from where it is taut under the body's weight.

    Where the body sags towards its cable, it is slack at first: pulls count from there.

    Args:
        robot: of the guess.
        guess: the guessed fields.
        part: its file, for messages.
        share: of the guessed pull that is tried first, then halves of it.

    Raises:
        PartError: no pull of `LEAST_SHARE` or more has an equilibrium.
    """
    sim = settled(robot, part)
    while share >= LEAST_SHARE:
        sim.reset()
        start, slack = sim.effector[0], max(float(sim.position[0]), 0.0)
        most = slack + share * guess.max_pull
        half = sim.settle(position=[slack + HALF * share * guess.max_pull])
        effort, tip = float(sim.effort[0]), sim.effector[0]
        if half.converged and effort > 0.0 and sim.settle(position=[most]).converged:
            return Reached(effort, tip, float(np.linalg.norm(tip - start)), share, most)
        share *= 0.5
    raise PartError(
        f"{part}: the guessed cable finds no equilibrium at {1e3 * LEAST_SHARE * guess.max_pull:.2g} mm of "
        "pull; turn the part so that its longest side runs from where it is held to its tip"
    )


def inflated(robot: Robot, guess: Guess, young: float, part: str, share: float = 1.0) -> Reached:
    """Inflate all guessed chambers alike, as far as there is an equilibrium and the tip stays near.

    The pressure doubles from a small one on: an equilibrium that is not there takes far longer to search than
    one that is.

    Args:
        robot: of the guess.
        guess: the guessed fields.
        young: Young's modulus [Pa].
        part: its file, for messages.
        share: of the guessed pressure, at most.

    Raises:
        PartError: no pressure of `LEAST_PRESSURE` or more has one.
    """
    sim = settled(robot, part)
    start, nowhere = sim.effector[0], np.full(robot.n_a, np.nan)
    half, found = start, None
    tried = HALF * LEAST_PRESSURE
    while tried <= share:
        pressure = tried * PRESSURE * young
        if not sim.settle(nowhere, np.full(robot.n_a, pressure)).converged:
            break
        tip = sim.effector[0]
        away = float(np.linalg.norm(tip - start))
        if away >= FARTHEST * guess.length:
            break
        if tried >= LEAST_PRESSURE:
            volume = float(np.abs(sim.position).max())
            moved = float(np.linalg.norm(half - start))
            found = Reached(HALF * pressure, half, moved, tried, pressure, volume)
        if away > HALF * FARTHEST * guess.length:
            break  # twice the pressure would lead too far
        half, tried = tip, tried / HALF
    if found is None:
        raise PartError(
            f"{part}: the guessed chambers find no equilibrium at {LEAST_PRESSURE * PRESSURE * young:.2g} "
            "Pa; with --no-chambers a cable moves the part"
        )
    return found


def step_time(robot: Robot) -> float:
    """Processor time of a control step from the robot's start [s]."""
    controller = Controller(robot)
    controller.settle_start()
    controller.step(controller.effector_values)
    return step_seconds(controller, STEPS, thread_time)
