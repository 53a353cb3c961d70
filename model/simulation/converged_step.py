"""One step of implicit Euler, iterated until it holds at its end: for a simulated robot, not for control.

The end q of a step of length h from q₀, v₀ is a minimum of the incremental potential

    Φ(q) = ½ (v − v₀)ᵀ M (v − v₀) + ½ h vᵀ C v − h vᵀ f + Π(q),   q = q₀ ⊕ h v           (C1)

under the constraints of cables and contacts at q; Π is the energy of elasticity, gravity and outer forces,
M and C mass and damping at the start of the step, f the forces of inertia and of viscous materials' memory
there, ⊕ moves and turns the nodes. Newton with the exact tangent, or the positive semidefinite one where that
is not definite, solves a linear complementarity problem in each iteration; its first iteration is the step
with one linearisation. A line search on Φ and the exact penalty of the constraints
(`tauten.model.simulation.equilibrium`) bounds the iterations. (Kane, Marsden, Ortiz and West, International
Journal for Numerical Methods in Engineering 49, 2000; Li et al., Incremental Potential Contact, 2020.)

Because Φ(q) ≤ Φ(q₀), the end has Π(q) ≤ E₀ = Π(q₀) + ½ v₀ᵀ M v₀, plus the work of winches. Where Π is
convex along the step and M constant, Π(q) + ½ vᵀ M v ≤ E₀ follows. Where they are not (a beam that snaps, a
lever that turns), implicit Euler may gain energy; v is then scaled down to the velocity at which the energies
are equal.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.model.numerics import Array, FactorisationError
from tauten.model.robot import Robot
from tauten.model.signals import Command
from tauten.model.simulation.equilibrium import Ending, Found, Merit, make_report
from tauten.model.state import State
from tauten.model.step import (
    ContactSpace,
    Enrichment,
    Forces,
    PredictedStep,
    condensed,
    forward_step,
)
from tauten.model.system import System

ITERATIONS = 40  # linearisations of a step at most
TOLERANCE = 1e-5  # of the robot's size, displacement of a node in the last iteration; its error is far below
LINEAR = 2e-3  # of the size of the robot's largest part; a step that moves all nodes less is nearly linear
GAIN = 1e-2  # of the kinetic energy at the end of a step, which one linearisation may add
CONTRACTION = 0.2  # iterations that shorten by this are in Newton's basin, and taken whole


def converged_step(
    robot: Robot,
    space: ContactSpace,
    enrichment: Enrichment,
    state: State,
    forces: Forces,
    command: Command,
) -> Found:
    """Iterate a step until no node moves farther than TOLERANCE allows, at most ITERATIONS times.

    Raises:
        FactorisationError: the state has diverged.
    """
    robot = robot.stepping(state)
    start = robot.body.step_start(state)

    def potential(at: State) -> float:
        """Φ of (C1) [J]."""
        return robot.body.step_energy(start, robot.body.velocity(state, at)) + robot.potential(at)

    system = robot.body.linearise_iterate(state, start, forces.effort)

    def moved(at: State, system: System, dv: Array) -> State:
        return robot.advance(at, system.v + dv, system.h)

    merit = Merit(robot, space, command, potential, moved)
    contacts = space.k > 0 or enrichment.rounds > 0
    iterate, lam, taken, movement = state, forces, 0, np.inf
    last: PredictedStep | None = None
    ending = Ending.OUT_OF_ITERATIONS
    while taken < ITERATIONS and ending is not Ending.SETTLED:
        if last is not None:
            try:
                system = robot.body.linearise_iterate(iterate, start, lam.effort)
            except FactorisationError:
                ending = Ending.NOT_FINITE
                break
        slid = None if last is None else system.h * robot.body.velocity(state, iterate)
        step = condensed(robot, space, iterate, lam, system, contacts, False, slid)
        solved, taken = forward_step(step, enrichment, lam, command), taken + 1
        length = robot.displacement(iterate, system.h * solved.dv)
        if last is None and not np.isfinite(length):
            raise FactorisationError("the first iteration of the step is not finite")
        merit.observe(solved)
        near = length < max(CONTRACTION * movement, TOLERANCE * robot.size)
        share = 1.0 if near and last is not None else merit.share(solved, 1.0)
        if not np.isfinite(length) or share == 0.0:
            ending = Ending.NOT_FINITE
            break
        iterate = moved(iterate, system, share * solved.dv)
        lam, last, movement = solved.step.split(solved.lam, space.k), solved, length
        if movement < TOLERANCE * robot.size:
            ending = Ending.SETTLED
    if last is None:
        raise FactorisationError("the step leads to no finite state")
    end = robot.advance(state, robot.body.velocity(state, iterate), system.h)
    end = without_gain(robot, state, end, lam, _pushed(last, lam, space))
    return Found(end, lam, make_report(robot, end, last, taken, movement, ending), last)


def _pushed(last: PredictedStep, forces: Forces, space: ContactSpace) -> float:
    """The work that obstacles do in a step by their motion [J]."""
    step = last.step
    found, h = step.rows.contacts.found, step.system.h
    if found.surface is None:
        return 0.0
    return h * float((forces.on(found, space).force * found.surface).sum())


def without_gain(
    robot: Robot, before: State, after: State, forces: Forces, pushed: float = 0.0
) -> State:
    """The end of a step, with a velocity that gains no energy beyond the work of winches and obstacles.

    In quasi-static steps only what floats has a velocity.

    Args:
        robot: the robot.
        before: the start of the step.
        after: the end of the step.
        forces: constraint forces at the end.
        pushed: work of the obstacles [J].
    """
    if robot.integration.static:
        after = replace(after, v=robot.body.floating_velocity(after))
    positions = [robot.rows(at, False, False).actuators.delta for at in (before, after)]
    work = pushed + float(forces.effort @ (positions[1] - positions[0]))
    gain = robot.energy(after) - robot.energy(before) - work
    if not gain > 0.0:
        return after
    kinetic = robot.body.kinetic_energy(after)
    share = max(kinetic - gain, 0.0) / kinetic if kinetic > 0.0 else 0.0
    return replace(after, v=np.sqrt(share) * after.v)


def gains_energy(robot: Robot, taken: PredictedStep) -> bool:
    """Whether a dynamic step with one linearisation gains energy beyond the work of what pushes the robot.

    A linear step loses energy. One that turns parts far stretches them, and what keeps the axes of hinges:
    where only the steps damp a robot, its energy then grows from step to step.
    """
    step, start, v = taken.step, taken.step.state, taken.step.system.v + taken.dv
    h, size = step.system.h, robot.part_size
    if robot.integration.static or not LINEAR * size < robot.displacement(start, h * v) < np.inf:
        return False
    end = robot.body.advance(start, v, h)
    work = h * float(taken.lam @ (step.compliance.H @ v))
    gain = robot.energy(end) - robot.energy(start) - work
    return not gain <= GAIN * robot.body.kinetic_energy(end)
