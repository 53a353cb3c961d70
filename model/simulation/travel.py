"""From one command to the next in steps of second order, along which the actuators move evenly.

A step of length h has two stages, each a step of implicit Euler of length γh, γ = 1 − 1/√2:

    y₁ = y + γh f(y₁),   s = y + (1/γ − 1)(y₁ − y),   y₂ = s + γh f(y₂)                  (S1)

The end y₂ is accurate to second order, and what is stiff decays in a step, as with implicit Euler (Alexander,
SIAM Journal on Numerical Analysis 14, 1977). Cables and contacts are constraints at the end of each stage. A
stage has one linearisation, where the velocity alone leads: linearised at its start, it would stretch what
turns (docs/time-steps.md). Quasi-static steps have one stage.

The controller's model and the simulated robots both move so, each with its own number of steps in a period.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model.robot import Robot
from tauten.model.signals import Command
from tauten.model.state import State
from tauten.model.step import (
    ContactSpace,
    Enrichment,
    Forces,
    ForwardStep,
    condense_step,
    forward_step,
)
from tauten.model.system import Integration, coasting

STAGE = 1.0 - 1.0 / np.sqrt(2.0)  # γ


@dataclass(frozen=True, slots=True)
class Travel:
    """The end of a period.

    Attributes:
        state: there.
        forces: constraint forces of the last stage.
        last: the last stage.
        movement: largest displacement of a node in it [m].
        converged: whether the complementarity problem of every stage met its tolerance.
    """

    state: State
    forces: Forces
    last: ForwardStep
    movement: float
    converged: bool


def travel(
    robot: Robot,
    space: ContactSpace,
    enrichment: Enrichment,
    state: State,
    forces: Forces,
    before: Command,
    command: Command,
    steps: int,
) -> Travel:
    """Move a robot by its period under actuators that move evenly from one command to another.

    Args:
        robot: its factorisation workspace is in use until the next call.
        space: basis of the contact forces.
        enrichment: when unit columns join.
        state: where the period starts.
        forces: constraint forces there.
        before: positions and efforts at the start; where one is not given (NaN), that of `command` holds in
            the whole period.
        command: position or effort of each actuator at the end.
        steps: into how many the period is divided, at least 1.

    Raises:
        FactorisationError: the state has diverged.
    """
    position = np.where(np.isnan(before.position), command.position, before.position)
    effort = np.where(np.isnan(before.effort), command.effort, before.effort)
    stages, converged = _Stages(robot, space, enrichment, _scheme(robot, steps)), True
    for number in range(steps):
        start, last = state, number + 1 == steps
        if not stages.scheme.static:
            share = (number + STAGE) / steps
            middle = stages.solve(start, forces, command.between(position, effort, share))
            start = _beyond(robot, state, middle.state, stages.scheme.h)
            forces, converged = middle.forces, converged and middle.converged
        now = command if last else command.between(position, effort, (number + 1) / steps)
        end = stages.solve(start, forces, now)
        state, forces, converged = end.state, end.forces, converged and end.converged
    return replace(end, converged=converged)


@dataclass(frozen=True, slots=True)
class _Stages:
    """Steps of implicit Euler of one length; attributes as the arguments of `travel`."""

    robot: Robot
    space: ContactSpace
    enrichment: Enrichment
    scheme: Integration

    def solve(self, start: State, forces: Forces, command: Command) -> Travel:
        """One of them.

        Args:
            start: where it starts.
            forces: constraint forces before it.
            command: at its end.
        """
        robot, space, scheme = self.robot, self.space, self.scheme
        contacts = space.k > 0 or self.enrichment.rounds > 0
        at = start if scheme.static else _ahead(robot, start, scheme.h)
        step = condense_step(robot, space, at, forces, contacts, False, scheme)
        last = forward_step(step, self.enrichment, forces, command)
        solved = last.prediction
        system = step.system if scheme.static else replace(step.system, v=start.v)
        movement = robot.displacement(start, system.h * (system.v + solved.dv))
        state = robot.advance(start, system, solved.dv)
        return Travel(state, solved.step.split(solved.lam, space.k), last, movement, last.converged)


def _scheme(robot: Robot, steps: int) -> Integration:
    """The scheme of a stage, where a period is divided into some steps."""
    scheme, rate = robot.integration, steps * robot.integration.rate
    if scheme.static:
        return replace(scheme, rate=rate)
    return replace(scheme, rate=rate / STAGE, ahead=True)


def _ahead(robot: Robot, state: State, h: float) -> State:
    """Where the velocity alone leads from a state, with the velocity and memory of that state.

    Args:
        robot: the robot.
        state: where a stage starts.
        h: its length [s].
    """
    there = robot.advance(state, coasting(h, state.v), np.zeros(robot.n))
    return replace(there, memory=state.memory)


def _beyond(robot: Robot, start: State, middle: State, h: float) -> State:
    """Where the second stage starts: s of (S1).

    Args:
        robot: the robot.
        start: y, where the first stage started.
        middle: y₁, where it ended.
        h: length of a stage [s].
    """
    farther = 1.0 / STAGE - 1.0
    there = robot.advance(start, coasting(farther * h, middle.v), np.zeros(robot.n))
    return replace(there, v=start.v + farther * (middle.v - start.v))
