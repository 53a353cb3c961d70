"""The search for an equilibrium: linearised steps under a load that grows.

Each step solves the quasi-static system, factorised once. The load moves from its start to the command
as far as a step may be long, REACH of the body: forces under several loads are found with the same factors.
Where the state is out of balance by more than that, the load waits, and a line search on a merit
(`tauten.model.simulation.equilibrium`) bounds steps that do not become shorter. So the state follows a branch
of equilibria without settling on it, and descends to another one where the branch ends.

Steps of robots that can turn elements do so instead of stretching them (`Robot.turning_steps`). Nodes of
beams move along arcs, but along straight lines where contacts push: steps along arcs do not always become
short there.
Near the end, where the tangent is not exact or contacts push, whose normals turn, steps are extrapolated by
Anderson's method.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.model.numerics import Anderson, Array, FactorisationError
from tauten.model.robot import Robot
from tauten.model.signals import Command
from tauten.model.simulation.equilibrium import (
    Ending,
    Found,
    Merit,
    Report,
    make_report,
)
from tauten.model.simulation.stability import way_on
from tauten.model.simulation.way_in import WayIn
from tauten.model.state import State
from tauten.model.step import (
    CondensedStep,
    ContactSpace,
    Enrichment,
    Forces,
    PredictedStep,
    forward_step,
)
from tauten.model.system import System, smaller_share
from tauten.model.threads import raise_interrupt

REACH = 0.1  # of the body, a step at most
CLOSE = 0.8  # of the reach; a correction that takes more leaves nothing to the load
GROWTH = 2.0  # of a step of the load, from one to the next
NEAR = 2e-3  # of the body; shorter steps are linear, and extrapolated where they converge slowly
DEPTH = 10  # steps that are extrapolated from: every contact that turns may have a direction that diverges
# Every second straight step only takes back what the one before has stretched: so many steps may be longer
# than the shortest before they are searched along.
PATIENCE = 16


class EquilibriumSearch:
    """Searches equilibria of one robot."""

    def __init__(self, robot: Robot, space: ContactSpace, enrichment: Enrichment) -> None:
        """Prepare."""
        self.robot, self._space, self._enrichment = robot, space, enrichment
        self._reach, self._near = REACH * robot.size, NEAR * robot.size
        self._turning = robot.body.turning_steps()

    def run(
        self,
        state: State,
        forces: Forces,
        command: Command,
        start: Command,
        tolerance: float,
        max_iterations: int,
    ) -> Found:
        """Search from a state; where steps diverge, the last finite state is kept.

        Args:
            state: where the search starts.
            forces: constraint forces there.
            command: positions or efforts of the actuators at the end.
            start: those from which the load grows; the command itself where it does not grow.
            tolerance: largest displacement of a node in the last step [m].
            max_iterations: linearised steps at most.
        """
        robot = self.robot
        load, result, movement, taken, pushed = GrowingLoad(start, command), None, np.inf, 0, 0
        shares, ending = self._shares(load.now), Ending.OUT_OF_ITERATIONS
        semidefinite = 0.0  # share in the tangent that is tried first
        way_in = WayIn(robot, state)
        while taken < max_iterations:
            raise_interrupt()
            taken += 1
            try:
                step = self._condensed(way_in, state, forces, semidefinite)
                found, grown = self._solved(step, forces, load)
            except FactorisationError:
                ending = Ending.NOT_FINITE
                break
            if grown:
                shares = self._shares(load.now)
            length = self._length(found)
            solved = found.step.split(found.lam, self._space.k)
            if not solved.of_same_contacts(forces):
                shares.restart()
            dv = shares.step(found, length, grown) if np.isfinite(length) else found.dv
            after = self._moved(state, step.system, dv)
            if not np.isfinite(length) or not np.isfinite(after.q).all():
                ending = Ending.NOT_FINITE
                break
            state, forces, result, movement = after, solved, found, length
            used = step.system.semidefinite
            semidefinite = smaller_share(used) if used == semidefinite else used
            if load.complete and movement < tolerance:
                ending, push = way_on(robot, result, command.by_position, pushed)
                if push is None:
                    break
                pushed, movement = pushed + 1, np.inf
                state = self._moved(state, step.system, push)
                shares = self._shares(load.now)
        state = State(state.q, np.zeros_like(state.v))
        if pushed > 0 and ending is not Ending.SETTLED:
            ending = Ending.BUCKLED
        if result is None:
            nothing = Report(False, taken, np.inf, np.inf, np.inf, 0, Ending.NOT_FINITE, 0.0)
            return Found(state, forces, nothing, None)
        report = make_report(robot, state, result, taken, movement, ending)
        return Found(state, forces, report, result)

    def _condensed(
        self, way_in: WayIn, state: State, forces: Forces, semidefinite: float
    ) -> CondensedStep:
        contacts = self._space.k > 0 or self._enrichment.rounds > 0
        static = replace(self.robot.integration, static=True, semidefinite=semidefinite)
        step = way_in.condensed(self._space, state, forces, contacts, static)
        pushing = bool((forces.beta > 0.0).any()) or len(forces.pushing) > 0
        return replace(step, system=replace(step.system, straight=pushing))

    def _solved(
        self, step: CondensedStep, forces: Forces, load: GrowingLoad
    ) -> tuple[PredictedStep, bool]:
        """A step under the largest load within reach, and whether the load has grown; it is moved there."""

        def under(share: float, step: CondensedStep) -> tuple[PredictedStep, float]:
            found = forward_step(step, self._enrichment, forces, load.at(share))
            return found, self._length(found)

        top = load.next
        found, length = under(top, step)
        if top == load.share or length <= self._reach:
            return found, load.grow(top)
        kept, least = under(load.share, found.step)
        if not least < CLOSE * self._reach:
            return kept, False
        share = load.share + (top - load.share) * (self._reach - least) / (length - least)
        found, _ = under(share, kept.step)
        return found, load.grow(share)

    def _length(self, found: PredictedStep) -> float:
        """Largest displacement of a node in a step [m]."""
        return self.robot.displacement(found.step.state, found.step.system.h * found.dv)

    def _moved(self, state: State, system: System, dv: Array) -> State:
        """The state after a step that turns elements where it is long."""
        if self._turning is not None and self.robot.displacement(state, system.h * dv) > self._near:
            dv = self._turning(state, system.h * dv) / system.h
        return self.robot.advance(state, system.v + dv, system.h, system.straight)

    def _shares(self, command: Command) -> StepShares:
        merit = Merit(self.robot, self._space, command, self.robot.potential, self._moved)
        patience = PATIENCE if self._turning is None else 0
        return StepShares(self.robot, merit, self._reach, self._near, patience)


class GrowingLoad:
    """The load at a share of the way from that at the start to the command."""

    def __init__(self, start: Command, command: Command) -> None:
        """At the start."""
        self._start, self._command = start, command
        self.share, self._step = 0.0, 1.0

    @property
    def complete(self) -> bool:
        """Whether it has come to the command."""
        return self.share >= 1.0

    @property
    def next(self) -> float:
        """The share to try next."""
        return min(1.0, self.share + self._step)

    @property
    def now(self) -> Command:
        """The load at its share."""
        return self.at(self.share)

    def at(self, share: float) -> Command:
        """The load at a share of the way."""
        return self._command.between(self._start.position, self._start.effort, share)

    def grow(self, share: float) -> bool:
        """Move to a share; returns whether that is another one."""
        grown = share > self.share
        if grown:
            self._step, self.share = GROWTH * (share - self.share), share
        return grown


class StepShares:
    """How far steps under one load go."""

    def __init__(
        self, robot: Robot, merit: Merit, reach: float, near: float, patience: int
    ) -> None:
        """Before the first step.

        Steps have a reach [m], are linear where they are shorter than `near` [m], and are searched along
        after as many as `patience` that are longer than the shortest so far.
        """
        self._robot, self._merit, self._reach, self._near = robot, merit, reach, near
        self._shortest, self._anderson = np.inf, Anderson(DEPTH)
        self._patience, self._stalled = patience, 0

    def restart(self) -> None:
        """Extrapolate from no step before: other contacts push, which are another problem."""
        self._anderson.restart()

    def step(self, found: PredictedStep, length: float, grown: bool) -> Array:
        """The change of velocity (n,) to move by.

        Args:
            found: the step.
            length: largest displacement of a node in it [m].
            grown: whether the load grew in it, so that its length does not tell whether it converges.
        """
        h, dv = found.step.system.h, found.dv
        share = min(1.0, self._reach / max(length, 1e-300))
        if grown:
            return share * dv
        self._stalled = 0 if length < self._shortest else self._stalled + 1
        self._shortest = min(length, self._shortest)
        if length < self._near and (found.contacts_push or not found.step.system.exact):
            move = self._anderson.next(h * dv)
            if self._robot.displacement(found.step.state, move) <= self._near:
                return move / h
            self._anderson.restart()  # extrapolated beyond where it is linear
            return dv
        if self._stalled <= self._patience:
            return share * dv
        self._merit.observe(found)
        return self._merit.share(found, share) * dv
