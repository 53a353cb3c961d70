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
    """Inflate the largest guessed chamber alone and all alike, as far as the tip stays near at equilibria.

    Chambers around an axis bend the robot one at a time, and only stretch it together: where the tip is, is
    that of both which is farther from the start. The pressure doubles from a small one on: an equilibrium
    that is not there takes far longer to search than one that is.

    Args:
        robot: of the guess.
        guess: the guessed fields.
        young: Young's modulus [Pa].
        part: its file, for messages.
        share: of the guessed pressure, at most.

    Raises:
        PartError: no pressure of `LEAST_PRESSURE` or more has an equilibrium of each.
    """
    which = np.unique([np.arange(robot.n_a) == 0, np.full(robot.n_a, True)], axis=0)
    at_start, sims = settled(robot, part), [Simulator(robot, contact="none") for _ in which]
    for sim in sims:
        sim.start_from(at_start.state, at_start.forces)
    nowhere, found = np.full(robot.n_a, np.nan), None
    start = at_start.effector[0]
    half = np.tile(start, (len(sims), 1))
    tried = HALF * LEAST_PRESSURE
    while tried <= share:
        pressure = tried * PRESSURE * young
        if not all(
            sim.settle(nowhere, np.where(filled, pressure, 0.0)).converged
            for sim, filled in zip(sims, which, strict=True)
        ):
            break
        tips = np.stack([sim.effector[0] for sim in sims])
        away = np.linalg.norm(tips - start, axis=1)
        farther = int(away.argmax())
        if away[farther] >= FARTHEST * guess.length:
            break
        if tried >= LEAST_PRESSURE:
            volume = float(max(np.abs(sim.position).max() for sim in sims))
            tip = half[farther]
            moved = float(np.linalg.norm(tip - start))
            found = Reached(HALF * pressure, tip, moved, tried, pressure, volume)
        if away[farther] > HALF * FARTHEST * guess.length:
            break  # twice the pressure would lead too far
        half, tried = tips, tried / HALF
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
