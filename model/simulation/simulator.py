"""The forward simulator: a robot under given positions or efforts, step by step or settled."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from tauten.model.arguments import count, positive
from tauten.model.contact import ObstaclePoses
from tauten.model.numerics import Array, FactorisationError
from tauten.model.robot import Robot
from tauten.model.signals import Command
from tauten.model.simulation.commands import (
    Numbers,
    checked_command,
    checked_forces,
    checked_loads,
    checked_state,
    diverged,
    efforts_at_end,
)
from tauten.model.simulation.converged_step import converged_step
from tauten.model.simulation.equilibrium import Ending, Found, Report, make_report
from tauten.model.simulation.relaxation import relaxed
from tauten.model.simulation.robot_model import RobotModel
from tauten.model.simulation.search import EquilibriumSearch
from tauten.model.simulation.smooth_forces import smooth_contact_forces
from tauten.model.simulation.travel import travel
from tauten.model.state import State
from tauten.model.step import (
    NO_ENRICHMENT,
    ContactSpace,
    Enrichment,
    Forces,
    PredictedStep,
    condense_step,
    contact_model,
    forward_step,
    no_forces,
)
from tauten.model.threads import one_blas_thread

LEAST_LOAD_STEP = 1.0 / 64.0  # share of the way to the command
LOAD_STEP_ITERATIONS = 60  # of the search for a share of the load, so that smaller ones are tried
STATIC_TOLERANCE, STATIC_ITERATIONS = 1e-6, 200  # of the largest part's size; of equilibria
START_ITERATIONS = 60  # of each attempt to settle before the start
FASTEST = 2.0  # of the size of the largest part, in a period; a model that is faster has diverged
LEFT_IN_TIME = (Ending.LIMIT_POINT, Ending.OUT_OF_ITERATIONS, Ending.BUCKLED)


class Simulator(RobotModel):
    """Forward simulation of a robot. Arrays that its properties return are copies."""

    def __init__(
        self,
        robot: Robot,
        contact: Literal["none", "full"] | ContactSpace = "full",
        enrichment: Enrichment | None = None,
    ) -> None:
        """Start at rest.

        Args:
            robot: what to simulate; the simulator makes a workspace of its own.
            contact: "full", pointwise to 1e-8 m; a basis of contact forces, which is faster; or "none".
            enrichment: when unit columns join; default: for "full" to 1e-8 m, for a basis never.

        Raises:
            TypeError, ValueError: no robot; `contact` is none of these, or a basis of another robot's size.
        """
        self._robot = self._forked(robot)
        self.space, self._enrichment = contact_model(
            contact, self.robot.contacts, NO_ENRICHMENT, enrichment
        )
        self._search: EquilibriumSearch | None = None
        self._start = self.robot.rest(), no_forces(self.robot.n_a, self.space.k)
        self.reset()

    @classmethod
    def of(
        cls,
        robot: str | Path,
        model: Literal["full", "reduced"] | None = None,
        contact: str | None = None,
    ) -> Simulator:
        """The model that `Controller.of` decides with, as a simulator, settled under its loads.

        Args:
            robot: name of a shipped robot or path of a robot file, which names bases and settings.
            model: another model than the file's.
            contact: another contact than the file's: "full", "none", or the name of a basis.

        Raises:
            RobotFileError, MeshError, BasisError, StateBasisError: what it names cannot be used.
        """
        from tauten.controller.starting import started_simulator  # which imports this module

        return started_simulator(robot, model, contact)

    def reset(self) -> None:
        """Return to the start: rest without forces, unless `settle_start` found another one."""
        self.start_from(*self._start)
        self.set_obstacles(self.obstacles.at_start())

    def settle_start(self) -> Report:
        """Start from the equilibrium under the loads with the actuators at rest, also after each `reset`.

        Actuators that a hold keeps by their position are at zero, the others have no effort. Where no
        equilibrium is found, the start is rest.
        """
        self._start = self.robot.rest(), no_forces(self.robot.n_a, self.space.k)
        self.reset()
        held = self.robot.actuators.laws.held(*np.zeros((2, self.robot.n_a)))
        report = self.settle(held.position, held.effort, max_iterations=START_ITERATIONS)
        if report.converged:
            self._start = self.state, self.forces
        self.reset()
        return report

    def start_from(self, state: State, forces: Forces | None = None) -> None:
        """Start from another state, with constraint forces in this simulator's basis there, by default zero.

        Raises:
            TypeError, ValueError: these are none, or of another robot or basis, by their size.
        """
        self._state = checked_state(self._robot, state)
        self._forces = checked_forces(self._robot, self.space.k, forces)
        self._stepped: tuple[State, PredictedStep] | None = None  # a state, and the step there
        # of the last `move`: command, mean efforts and those at its end; None: another step is the last
        self._moved: tuple[Command, Array, Array] | None = None

    def load(self, gravity: Numbers, effector_force: Numbers) -> None:
        """Change the loads: gravity (3,) [m/s²] and forces on the effectors (3 p,) [N].

        Raises:
            ValueError: another shape, not finite, or beyond 1e6.
        """
        acceleration, forces = checked_loads(self._robot, gravity, effector_force)
        self._robot, self._search = self._robot.loaded(acceleration, forces), None

    def set_obstacles(self, poses: ObstaclePoses) -> None:
        """Have the obstacles in other poses from the next step on."""
        if poses is not self.obstacles:
            super().set_obstacles(poses)
            self._search = None

    @property
    def position(self) -> Array:
        """Positions of the actuators: (n_a,) [m, m³]."""
        delta = self.robot.rows(self._state, False, False).actuators.delta
        return self.robot.actuators.laws.motors(delta, self._forces.effort)

    @property
    def effort(self) -> Array:
        """Efforts of the actuators in the last step, after a `move` at its end: (n_a,) [N, Pa]."""
        return (self._forces.effort if self._moved is None else self._moved[2]).copy()

    @property
    def gaps(self) -> Array:
        """Signed gap of every candidate, +inf where out of range: (n_c,) [m]."""
        return self.robot.rows(self._state).contacts.found.gaps()

    @one_blas_thread(whole=True)
    def step(
        self,
        position: Numbers | None = None,
        effort: Numbers | None = None,
        converged: bool = False,
    ) -> Report:
        """One time step h under given positions or efforts of the actuators.

        With both arrays, each actuator has a number in one of them and NaN in the other.

        Args:
            position: (n_a,) positions, of cables pulled lengths [m, m³].
            effort: (n_a,) efforts, of cables tensions, not negative [N, Pa].
            converged: iterate the step until it holds at its end; it then gains no energy
                (`tauten.model.simulation.converged_step`). Otherwise it has one linearisation, at its start.

        Raises:
            ValueError: not exactly one of the two for each actuator, a wrong shape, not finite, negative
                tensions of cables, or values beyond 1e6 (efforts of other actuators 1e9).
            FactorisationError: the state has diverged.
        """
        command = checked_command(self.robot, position, effort)
        self.set_obstacles(self.obstacles.after(self.robot.h))
        if converged and self.robot.integration.static and not self.robot.floats:
            tolerance = STATIC_TOLERANCE * self.robot.part_size
            return self._attempt(command, command, tolerance, STATIC_ITERATIONS)
        if converged:
            robot, space, enrichment = self.robot, self.space, self._enrichment
            return self._taken(
                converged_step(robot, space, enrichment, self._state, self._forces, command)
            )
        result, movement = self._advance(command)
        return make_report(self.robot, self._state, result, 1, movement, self._ending())

    @one_blas_thread(whole=True)
    def move(
        self,
        position: Numbers | None = None,
        effort: Numbers | None = None,
        steps: int = 1,
    ) -> Report:
        """A period h in steps of second order, see `tauten.model.simulation.travel`.

        Positions and efforts of the actuators move evenly from those of the last `move`, at first and after
        a step or a settling from those of the state, to the given ones. Efforts at the end are extrapolated
        from the means of the last two moves (`tauten.model.simulation.commands`).

        Args:
            position: (n_a,) positions at the end, as of `step`.
            effort: (n_a,) efforts at the end.
            steps: into how many the period is divided.

        Raises:
            ValueError: as of `step`, or `steps` below 1.
            FactorisationError: the state has diverged; where efforts before it, or of one step through the
                period, are beyond their limits, the text names the largest.
        """
        steps = count("steps", steps)
        command = checked_command(self.robot, position, effort)
        if self._moved is None:
            before, mean = Command(self.position, self._forces.effort), self._forces.effort
        else:
            before, mean, _ = self._moved
        self.set_obstacles(self.obstacles.after(self.robot.h))
        robot, space, enrichment = self._robot, self.space, self._enrichment
        start = self._state, self._forces
        try:
            done = travel(robot, space, enrichment, *start, before, command, steps)
        except FactorisationError as error:
            efforts = [self.effort]
            with suppress(FactorisationError):
                self._advance(command)
                efforts.append(self.effort)
            self._state, self._forces = start
            raise FactorisationError(diverged(self.robot, efforts, error)) from error
        now = ends = done.forces.effort
        if done.effort is not None:
            now, laws = done.effort, self.robot.actuators.laws
            ends = efforts_at_end(laws, command, mean, now)
        self._state, self._forces, self._moved = done.state, done.forces, (command, now, ends)
        self._stepped = done.state, done.last
        movement = self._robot.displacement(done.start, done.way)
        return make_report(self.robot, done.state, done.last, steps, movement, self._ending())

    def _ending(self) -> Ending:
        """How a step ended, by the velocity that it left; what no actuator pulls may be thrown as fast."""
        way = self.robot.displacement(self._state, self.robot.h * self._state.v)  # in a period [m]
        slow = way < FASTEST * self.robot.part_size or not self._forces.effort.any()
        return Ending.SETTLED if slow else Ending.NOT_FINITE  # also where the velocity is NaN

    @one_blas_thread(whole=True)
    def settle(
        self,
        position: Numbers | None = None,
        effort: Numbers | None = None,
        tolerance: float | None = None,
        max_iterations: int = STATIC_ITERATIONS,
        load_steps: bool = True,
    ) -> Report:
        """Move to equilibrium under given positions or efforts of the actuators, see `step`.

        Newton steps of the quasi-static system, while the load grows from that at the start to the
        command as far as a step may reach (`tauten.model.simulation.search`). A state out of balance
        descends on a merit function (`tauten.model.simulation.equilibrium`), to another branch of
        equilibria where one ends, as a robot that snaps does.

        An equilibrium that is unstable (a column pushed straight beyond Euler's load) is left along the
        direction of its negative stiffness. Where no stable one is found, the report says BUCKLED.

        Where that does not converge, shares of the load are settled, each half as far beyond the last
        equilibrium as the one that failed. Where even the shortest fails, the robot snaps: it moves on in
        damped time steps under the command (`tauten.model.simulation.relaxation`). Where no equilibrium is
        found after these, the state is the last one found, and the report says for which share of the way
        and why.

        Args:
            position: (n_a,) positions, of cables pulled lengths [m, m³].
            effort: (n_a,) efforts, of cables tensions, not negative [N, Pa].
            tolerance: largest displacement of a node in the last step [m]; None: a millionth of the size of
                the robot's largest part.
            max_iterations: linearised steps at most, at least 1: of the first search, and of all shorter
                ones; then `converged` is False.
            load_steps: without them the whole load acts at once, there is one search, and its last finite
                state is kept.

        Raises:
            ValueError: as of `step`, `max_iterations` below 1, or a tolerance that is not positive.
        """
        max_iterations = count("max_iterations", max_iterations)
        least = STATIC_TOLERANCE * self.robot.part_size
        tolerance = least if tolerance is None else positive("tolerance", tolerance)
        command = checked_command(self.robot, position, effort)
        if not load_steps:
            return self._attempt(command, command, tolerance, max_iterations)
        before = self._state, self._forces
        start = command.between(self.position, self._forces.effort, 0.0)
        report = self._attempt(command, start, tolerance, max_iterations)
        if report.converged:
            return report
        self._state, self._forces = before
        return self._in_load_steps(command, start, tolerance, max_iterations, report)

    def _in_load_steps(
        self,
        command: Command,
        start: Command,
        tolerance: float,
        max_iterations: int,
        failed: Report,
    ) -> Report:
        """Settle shares of the load after a failed search; the state is the last equilibrium found."""
        share, step, taken, last, now = 0.0, 0.5, 0, failed, start
        while share < 1.0 and step >= LEAST_LOAD_STEP and taken < max_iterations:
            following = min(share + step, 1.0)
            good = self._state, self._forces
            load = command.between(start.position, start.effort, following)
            most = min(LOAD_STEP_ITERATIONS, max_iterations - taken)
            last = self._attempt(load, now, tolerance, most)
            taken += last.iterations
            if last.converged:
                share, now = following, load
            else:
                self._state, self._forces = good
                step *= 0.5
        taken += failed.iterations
        if share < 1.0 and last.ending in LEFT_IN_TIME:
            good = self._state, self._forces
            robot, space, enrichment = self._at_rest(), self.space, self._enrichment
            self._state, self._forces = relaxed(robot, space, enrichment, *good, command)
            snapped = self._attempt(command, command, tolerance, LOAD_STEP_ITERATIONS)
            taken += snapped.iterations
            if snapped.converged:
                return replace(snapped, iterations=taken)
            self._state, self._forces = good
        return replace(last, iterations=taken, share=share)

    def _at_rest(self) -> Robot:
        """The robot with obstacles that stand still, as an equilibrium has them."""
        return self.robot.with_obstacles(self.obstacles.still())

    def _attempt(
        self, command: Command, start: Command, tolerance: float, max_iterations: int
    ) -> Report:
        """Search an equilibrium under a command, as `settle` does once; its last finite state is kept."""
        if self._search is None:
            self._search = EquilibriumSearch(self._at_rest(), self.space, self._enrichment)
        state, forces = self._state, self._forces
        return self._taken(
            self._search.run(state, forces, command, start, tolerance, max_iterations)
        )

    def _taken(self, end: Found) -> Report:
        """Move to where a search or a step ended."""
        self._state, self._forces, self._moved = end.state, end.forces, None
        self._stepped = None if end.last is None else (end.state, end.last)
        return end.report

    @one_blas_thread(whole=True)
    def smooth_contact_forces(self) -> Array:
        """Normal forces of nearly least norm at the equilibrium: (n_c,) [N]; the state does not change.

        Pointwise forces are not unique where candidates are finer than the mesh; snapshots need smooth ones.
        """
        return smooth_contact_forces(self.robot, self._state, self._forces)

    def _advance(self, command: Command) -> tuple[PredictedStep, float]:
        """One time step, and the largest displacement of a node in it [m]."""
        contacts = self.space.k > 0 or self._enrichment.rounds > 0
        robot = self.robot.stepping(self._state, far=True)
        step = condense_step(robot, self.space, self._state, self._forces, contacts, False)
        solved = forward_step(step, self._enrichment, self._forces, command)
        system = step.system
        v = system.v + solved.dv
        movement = self.robot.displacement(self._state, system.h * v)
        self._state = self.robot.advance(self._state, v, system.h)
        self._forces = solved.step.split(solved.lam, self.space.k)
        self._stepped, self._moved = (self._state, solved), None
        return solved, movement
