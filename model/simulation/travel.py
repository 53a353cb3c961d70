"""From one command to the next in steps of second order, along which the actuators move evenly.

A step of length h has two stages, each a step of implicit Euler of length γh, γ = 1 − 1/√2:

    y₁ = y + γh f(y₁),   s = y + (1/γ − 1)(y₁ − y),   y₂ = s + γh f(y₂)                  (S1)

The end y₂ is accurate to second order, and what is stiff decays in a step, as with implicit Euler (Alexander,
SIAM Journal on Numerical Analysis 14, 1977). Cables and contacts are constraints at the end of each stage. A
stage has one linearisation, where the velocity alone leads: linearised at its start, it would stretch what
turns (docs/time-steps.md). Quasi-static steps have one stage, and end at an equilibrium where that is far.

(S1) extrapolates the first stage. What cables and contacts do when they begin or cease to push must not be
extrapolated: a part that a cable stops in the first stage would start the second one with its velocity
reversed, and the cable, which can only pull, would let it go. There the second stage starts at y₁ and is a
step of implicit Euler over the rest of h, as steps for unilateral constraints treat impulses (Acary and
Brogliato, *Numerical Methods for Nonsmooth Dynamical Systems*, 2008, chapter 10). Where actuators change
their velocity, efforts of both stages have the same impulse, of which only their mean over the step tells.

The first stage does not show every impact. A body on an obstacle that starts to move would be thrown up
with 1/γ − 1 = 2.4 times its velocity, and one that meets an obstacle between y₁ and s be pushed out of it.
There other contacts push at the end of the second stage, which is repeated from y₁: after an impact bodies
have the velocity of the obstacle. Only what obstacles, or bodies that only contact joins, push counts.

Where a stage moves a node far from where the velocity alone leads, the period is travelled again in twice as
many steps, up to four times as many. Where it moves a node several times as far, as where a robot buckles and
its tangent is nearly singular, the number is doubled further.

The step in which something is struck is of first order. Where folds of a body meet or come apart, it leaves
a velocity that rings on for periods, and efforts alternate. There the period is travelled again in four times
as many steps, but for what an obstacle pushes, whose contacts begin and cease to push in most periods.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np

from tauten.model.numerics import Array, Bools, FactorisationError, Ints, kernel
from tauten.model.robot import Robot
from tauten.model.signals import Command
from tauten.model.simulation.balance import balanced, moves_far, within_reach
from tauten.model.simulation.turning import turning_as_at_end
from tauten.model.state import State
from tauten.model.step import (
    CondensedStep,
    ContactSpace,
    Enrichment,
    Forces,
    PredictedStep,
    condense_step,
    forward_step,
)
from tauten.model.system import Integration

_Pushing: TypeAlias = tuple[Array, Array, Ints, Array]

STAGE = 1.0 - 1.0 / np.sqrt(2.0)  # γ
FARTHEST_CORRECTION = 2e-3  # from where the velocity leads, of the size of the robot's largest part
DOUBLINGS = 2  # at most, of the number of steps in a period,
RESCUES = 5  # unless a stage leads this far from where the velocity does, or there is none:
VIOLENT = 5.0  # times FARTHEST_CORRECTION
TINY = float(np.finfo(float).tiny)  # the least positive number
PUSHES = 1e-9  # of that size: what moves less by its force in a stage does not push, it is rounding


@dataclass(frozen=True, slots=True)
class Travel:
    """The end of a period.

    Attributes:
        state: there.
        forces: constraint forces of the last stage.
        last: the last stage.
        start: where it started.
        way: (n,) displacement in it [m].
        correction: largest displacement of a node in any stage from where the velocity alone led [m].
        converged: whether the complementarity problem of every stage met its tolerance.
        effort: (n_a,) mean efforts of the actuators [N, Pa]; None: those of `forces`.
    """

    state: State
    forces: Forces
    last: PredictedStep
    start: State
    way: Array
    correction: float
    converged: bool
    effort: Array | None = None


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
        robot: its factorisation workspace is in use until the next call. Its obstacles are where they are at
            the end of the period, with the velocities that they have in it.
        space: basis of the contact forces.
        enrichment: when unit columns join.
        state: where the period starts.
        forces: constraint forces there.
        before: positions and efforts at the start; where one is not given (NaN), that of `command` holds in
            the whole period.
        command: position or effort of each actuator at the end.
        steps: into how many the period is divided, at least 1; more where that is not enough, see above.

    Raises:
        FactorisationError: the state has diverged.
    """
    static, size = robot.integration.static, robot.part_size
    farthest = FARTHEST_CORRECTION * size
    most, last = (steps, steps) if static else (steps << DOUBLINGS, steps << RESCUES)
    count, commands = steps, (before, command)
    while True:
        limit = farthest if count < most else VIOLENT * farthest
        limit = np.inf if count == last else limit
        stages = _Stages(robot, space, enrichment, _scheme(robot.integration, count), size)
        try:
            found = _in_steps(stages, state, forces, commands, count, limit, count == steps)
        except FactorisationError:
            if count == last:
                raise
        else:
            if found is None:
                count = most
                continue
            if found.correction <= limit:
                return found
        count *= 2


def _in_steps(
    stages: _Stages,
    state: State,
    forces: Forces,
    commands: tuple[Command, Command],
    steps: int,
    farthest: float,
    resolves: bool,
) -> Travel | None:
    """The period in a number of steps; only up to the first stage whose correction is too large.

    Args:
        stages: of these steps.
        state: where the period starts.
        forces: constraint forces there.
        commands: at the start and at the end.
        steps: their number.
        farthest: correction of a stage at which the period ends [m].
        resolves: whether it is None where a contact begins or ceases to push, and no obstacle is in range.
    """
    before, command = commands
    position, effort = command.starting(before)
    correction, converged, mean = 0.0, True, None
    for number in range(steps):
        share = (number + 1) / steps
        now = command if number + 1 == steps else command.between(position, effort, share)
        if stages.scheme.static:
            end = stages.solve(state, forces, now, share)
            if moves_far(stages.robot, end.last):
                start = command.between(position, effort, number / steps)
                end = stages.at_rest(state, forces, start, now)
        else:
            part = (number + STAGE) / steps
            end = stages.solve(state, forces, command.between(position, effort, part), part)
            correction, converged = max(correction, end.correction), converged and end.converged
            if end.correction > farthest:
                break
            struck = _struck(forces, end, PUSHES * stages.size)
            if struck and resolves and _strikes_itself(stages, forces, end):
                return None
            first, end = end, _second(stages, state, end, struck, now, share)
            last = 1.0 - STAGE if end.start is first.state else STAGE  # share of the second stage
            both = (1.0 - last) * first.forces.effort + last * end.forces.effort
            mean = both / steps if mean is None else mean + both / steps
        correction, converged = max(correction, end.correction), converged and end.converged
        if end.correction > farthest:
            break
        state, forces = end.state, end.forces
    return Travel(end.state, end.forces, end.last, end.start, end.way, correction, converged, mean)


def _second(
    stages: _Stages, start: State, first: Travel, struck: bool, command: Command, share: float
) -> Travel:
    """The second stage of a step: from s of (S1), or where something is struck over the rest, from y₁."""
    contacts = stages.robot.contacts
    if not struck:
        beyond = _beyond(stages.robot, start, first.state, stages.scheme.h)
        end = stages.solve(beyond, first.forces, command, share, start)
        if not contacts.loose and not contacts.poses.poses:
            return end
        outer = contacts.obstructed.copy()
        outer[list(contacts.loose)] = True
        if not _struck(first.forces, end, PUSHES * stages.size, _moved_by(outer, end)):
            return end
    return stages.over_the_rest().solve(first.state, first.forces, command, share)


def _strikes_itself(stages: _Stages, before: Forces, stage: Travel) -> bool:
    """Whether contacts of what no obstacle pushes in a stage have begun or ceased to push."""
    contacts = stages.robot.contacts
    counted: Bools | None = None
    if contacts.poses.poses:
        moved = _moved_by(contacts.obstructed, stage)
        counted = ~moved if moved.any() else None
    return _struck(before, stage, PUSHES * stages.size, counted, actuators=False)


def _moved_by(pairs: Bools, stage: Travel) -> Bools:
    """Which rows of a stage (m,) the forces of some of the contact pairs (n_pairs,) move."""
    step, found = stage.last.step, stage.last.step.rows.contacts
    units = step.layout.contacts.start + len(step.reduced)
    pushing: Bools = np.zeros(len(step.compliance), np.bool_)
    pushing[step.layout.contacts.start : units] = pairs[found.pair].any()
    pushing[units:] = np.repeat(pairs[found.pair[step.extra]], 3 if step.frictional else 1)
    moved: Bools = np.logical_or.reduce(step.compliance.W[:, pushing] != 0.0, axis=1)
    return moved


def _struck(
    before: Forces,
    stage: Travel,
    least: float,
    counted: Bools | None = None,
    actuators: bool = True,
) -> bool:
    """Whether a cable or a contact has begun or ceased to push, or a contact to slide or to stick.

    Forces at rest may be rounding, whose sign must not choose the scheme: a replay would end elsewhere.

    Args:
        before: forces before the stage.
        stage: the stage.
        least: displacement in the row of a cable or contact from which on a force pushes [m].
        counted: (m,) rows of the stage that count; None: all.
        actuators: whether cables count, and how contacts slide; else only whether contacts push.
    """
    step, after, kept = stage.last.step, stage.forces, slice(None if actuators else 0)
    places = step.layout.actuators.start, step.layout.contacts.start
    if counted is not None:
        before, after = _counted(before, step, counted), _counted(after, step, counted)
    # nothing begins where the effort of another actuator changes its sign
    pulls = ~step.laws.bilateral
    forces = (
        ((before.effort * pulls)[kept], before.beta, before.extra, before.extra_beta),
        ((after.effort * pulls)[kept], after.beta, after.extra, after.extra_beta),
    )
    changed = _pushes_otherwise(forces, step.compliance.W, places, least)
    rubs = actuators and before.friction is not None
    return changed or (rubs and before.slides_otherwise(after))


def _counted(forces: Forces, step: CondensedStep, counted: Bools) -> Forces:
    """The forces of some rows (m,) of a step; those of others are zero, or left out."""
    layout, modes, beta = step.layout, step.reduced.modes, forces.beta.copy()
    first = layout.contacts.start
    beta[modes] *= counted[first : first + len(modes)]
    units = counted[first + len(modes) :: 3 if step.frictional else 1]
    kept = np.isin(forces.extra, step.rows.contacts.slots[step.extra[units]])
    friction = None if forces.friction is None else forces.friction.of(kept)
    effort = np.where(counted[layout.actuators], forces.effort, 0.0)
    return Forces(effort, beta, forces.extra[kept], forces.extra_beta[kept], friction)


@kernel
def _pushes_otherwise(
    forces: tuple[_Pushing, _Pushing], W: Array, places: tuple[int, int], least: float
) -> bool:
    """Whether an actuator, a column of the basis or a unit column has begun or ceased to push.

    Args:
        forces: before and after: efforts (n_a,), of the basis (k,), and slots (r,) and forces (r,) of unit
            columns.
        W: (m, m) compliance of the rows [m/N].
        places: rows of the first actuator, and of the first contact.
        least: displacement in a row from which on a force pushes [m].
    """
    before, after = forces
    for i in range(len(before[0])):
        effort = least / max(W[places[0] + i, places[0] + i], TINY)
        if (before[0][i] > effort) != (after[0][i] > effort):
            return True
    unit = 0.0 if places[1] < len(W) else np.inf
    for row in range(places[1], len(W)):
        unit = max(unit, W[row, row])
    contact = least / unit
    for i in range(len(before[1])):
        if (before[1][i] > contact) != (after[1][i] > contact):
            return True
    one, other = before[2][before[3] > contact], after[2][after[3] > contact]
    return len(one) != len(other) or (one != other).any()


@dataclass(frozen=True, slots=True)
class _Stages:
    """Steps of implicit Euler of one length.

    Attributes, beside the arguments of `travel`:
        scheme: of these steps.
        size: of the robot's largest part [m].
    """

    robot: Robot
    space: ContactSpace
    enrichment: Enrichment
    scheme: Integration
    size: float

    def solve(
        self,
        start: State,
        forces: Forces,
        command: Command,
        share: float,
        origin: State | None = None,
    ) -> Travel:
        """One of them.

        Args:
            start: where it starts.
            forces: constraint forces before it.
            command: at its end.
            share: of the period that has passed then, which says where the obstacles are.
            origin: where the robot was last, if `start` is extrapolated from there; None: at `start`.
        """
        robot, space, scheme = self.robot, self.space, self.scheme
        contacts = space.k > 0 or self.enrichment.rounds > 0
        at = start if scheme.static else _ahead(robot, start, scheme.h)
        slid = None if scheme.static else scheme.h * start.v
        before, h = (start, scheme.h) if origin is None else (origin, scheme.h / STAGE)
        led, far = (None, robot.floats) if scheme.static else (at, False)
        robot = robot.stepping(before, h, led, far, (share - 1.0) * robot.h)
        step = condense_step(robot, space, at, forces, contacts, False, scheme, slid)
        if step.system.inertia is not None:
            step = turning_as_at_end(robot, step, forces)
        solved, h = forward_step(step, self.enrichment, forces, command), scheme.h
        dv, correction = solved.dv, robot.body.displacement(at, h * solved.dv)
        if correction > FARTHEST_CORRECTION * self.size and not scheme.static:
            dv, correction = within_reach(robot, at, dv, h)
        v = (step.system.v if scheme.static else start.v) + dv
        state = robot.body.advance(start, v, h)
        after = solved.step.split(solved.lam, space.k)
        return Travel(state, after, solved, start, h * v, correction, solved.converged)

    def at_rest(self, state: State, forces: Forces, start: Command, command: Command) -> Travel:
        """The equilibrium that the robot comes to while its actuators go from one command to another."""
        end, after, last, settled = balanced(
            self.robot, self.space, self.enrichment, state, forces, start, command
        )
        return Travel(end, after, last, last.step.state, last.step.system.h * last.dv, 0.0, settled)

    def over_the_rest(self) -> _Stages:
        """Steps that are as long as what the first stage leaves of the whole step."""
        rate = self.scheme.rate * STAGE / (1.0 - STAGE)
        return replace(self, scheme=replace(self.scheme, rate=rate))


@lru_cache(maxsize=64)
def _scheme(scheme: Integration, steps: int) -> Integration:
    """The scheme of a stage, where the period of a scheme is divided into some steps."""
    rate = steps * scheme.rate
    if scheme.static:
        return replace(scheme, rate=rate)
    return replace(scheme, rate=rate / STAGE, ahead=1.0)


def _ahead(robot: Robot, state: State, h: float) -> State:
    """Where the velocity alone leads from a state, with the velocity and memory of that state."""
    there = robot.body.advance(state, state.v, h)
    return there if there.memory is state.memory else State(there.q, there.v, state.memory)


def _beyond(robot: Robot, start: State, middle: State, h: float) -> State:
    """Where the second stage starts: s of (S1), of y = `start`, y₁ = `middle` and the length h of a stage."""
    farther = 1.0 / STAGE - 1.0
    there = robot.body.advance(start, middle.v, farther * h)
    v, memory = start.v + farther * (middle.v - start.v), there.memory
    if memory.size > 0:  # carried there from both, of which only y₁ has relaxed
        first, last = (robot.body.remembering(at, there, 0.0).memory for at in (start, middle))
        memory = first + farther * (last - first)
    return State(there.q, v, memory)
