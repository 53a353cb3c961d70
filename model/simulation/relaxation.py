"""Motion in time to an equilibrium, where a search along equilibria ends.

Beyond a limit point there is no equilibrium near the last one: the robot snaps. Its motion is followed in
time steps of implicit Euler, which are so long that they damp it. This is pseudo-transient continuation
(Kelley and Keyes, Convergence analysis of pseudo-transient continuation, SIAM J. Numer. Anal. 35, 1998) with
the mass as the matrix of the transient: the steps become longer while the robot moves little, and shorter
where one diverges.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.model.numerics import FactorisationError
from tauten.model.robot import Robot
from tauten.model.signals import Command
from tauten.model.simulation.way_in import WayIn
from tauten.model.state import State
from tauten.model.step import ContactSpace, Enrichment, Forces, forward_step
from tauten.model.threads import raise_interrupt

FIRST = 0.1  # s; of the time steps
SHORTEST, LONGEST = 1e-3, 1.0  # s; longer ones no longer follow the motion
GROWTH, SHRINKAGE = 1.25, 0.25  # from one time step to the next
STEPS = 150  # at most
FAR = 0.5  # of the body; a step that moves a node farther is taken again, shorter
STILL = 1e-6  # of the body; a step that moves every node less is the last. Motion starts slowly beside a
# limit point


def relaxed(
    robot: Robot,
    space: ContactSpace,
    enrichment: Enrichment,
    state: State,
    forces: Forces,
    command: Command,
) -> tuple[State, Forces]:
    """Move in damped time steps until the robot hardly moves: its state, without velocity, and its forces."""
    state = State(state.q, np.zeros_like(state.v))
    h, contacts = FIRST, space.k > 0 or enrichment.rounds > 0
    way_in = WayIn(robot, state)
    for _ in range(STEPS):
        raise_interrupt()
        scheme = replace(robot.integration, static=False, rate=1.0 / h)
        try:
            step = way_in.condensed(space, state, forces, contacts, scheme)
            solved = forward_step(step, enrichment, forces, command)
            movement = robot.displacement(state, h * (state.v + solved.dv))
        except FactorisationError:
            movement = np.inf
        if not movement <= FAR * robot.size:
            if h <= SHORTEST:
                break
            h *= SHRINKAGE
            continue
        state = robot.advance(state, step.system.v + solved.dv, h)
        forces = solved.step.split(solved.lam, space.k)
        if movement < STILL * robot.size:
            break
        h = min(GROWTH * h, LONGEST)
    return State(state.q, np.zeros_like(state.v)), forces
