"""The controller: a model of the robot that follows targets and computes its actuation."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from tauten.controller.actuation import NO_CERTIFICATE, Actuation, decided_actuation, unknown_rows
from tauten.controller.carried import nothing_carried
from tauten.controller.loading import Order
from tauten.controller.planning import (
    Prepared,
    horizon_of,
    locked,
    locks_of_step,
    no_locks,
    resting,
    unlocked,
    with_goal,
    with_locks,
)
from tauten.controller.qpcc import Backend, Status, TimeLimit
from tauten.controller.settings import ControllerSettings, checked_settings, decide_settings
from tauten.controller.step import Decision, advance, decide, hold, prepare
from tauten.model import (
    Command,
    ContactSpace,
    Enrichment,
    Forces,
    Grasp,
    ObstaclePoses,
    Report,
    Robot,
    RobotModel,
    Simulator,
    State,
    Target,
    contact_model,
    default_enrichment,
    no_forces,
    one_blas_thread,
)
from tauten.model.numerics import Array, Bools, FactorisationError


class Controller(RobotModel):
    """Inverse control of a robot, one decision a time step. Arrays that it returns are copies.

    `step` does all of it; a node calls `decide` at the tick, publishes, and then `advance` and `prepare`,
    so that the next step is ready before its target arrives. Between two calls of `advance` the last
    `decide` or `hold` counts, and each starts from the positions that left in the step before.

    Attributes, beside those of every `RobotModel`:
        horizon: how far its decisions look ahead.
        settings: of its decisions.
        settled: whether it starts from an equilibrium rather than from rest, see `settle_start`.
        status: how the last prepare, decide or hold ended.
    """

    def __init__(
        self,
        robot: Robot,
        contact: Literal["none", "full"] | ContactSpace = "full",
        enrichment: Enrichment | None = None,
        settings: ControllerSettings | None = None,
        qp: Backend | None = None,
    ) -> None:
        """Start at rest.

        Args:
            robot: what to control; the controller makes a workspace of its own.
            contact: "full", pointwise; a basis of contact forces, which is faster; or "none".
            enrichment: when unit columns join a basis; default: three rounds at the robot's tolerance.
            settings: of the inverse problem, see `load_controller_settings`; default: a bare file's.
            qp: solves the quadratic programs; default: the library that the settings name.

        Raises:
            TypeError, ValueError, RobotFileError: no robot; another `contact`; no installed QP library.
        """
        self._robot = self._forked(robot)
        reduced = default_enrichment(self.robot.tolerance)
        self.space, checked = contact_model(contact, self.robot.contacts, reduced, enrichment)
        settings = checked_settings(settings)
        self.horizon = horizon_of(self.robot, settings.horizon, settings.following_horizon)
        self.settings = decide_settings(settings, self.robot, self.space, checked, qp)
        self.settled, none = False, no_forces(self.robot.n_a, self.space.k)
        self._origin = self.robot.rest(), none, np.zeros(self.robot.n_a)
        self._decision: Decision | None = None
        self.reset()

    @classmethod
    def of(
        cls, robot: str | Path, model: Order | None = None, contact: str | None = None
    ) -> Controller:
        """The controller that `tauten serve` starts: settled under its loads, with its kernels compiled.

        Args:
            robot: name of a shipped robot or path of a robot file, which names bases and settings.
            model: another model than the file's.
            contact: another contact than the file's: "full", "none", or the name of a basis.

        Raises:
            RobotFileError, MeshError, BasisError, StateBasisError: what it names cannot be used.
        """
        from tauten.controller.starting import started_controller  # which imports this module

        return started_controller(robot, model, contact)

    def reset(self) -> None:
        """Return to the start without locks: rest without forces, unless `settle_start` found another one."""
        self._locks = no_locks(self.robot.n_a)
        self.set_obstacles(self.robot.obstacles.at_start())
        self.start_from(*self._origin)

    def settle_start(self) -> Report:
        """Start from the equilibrium under the loads with the actuators at rest, also after each `reset`.

        Where none is found, the start is rest, and the report says why; see `Simulator.settle_start`.
        Positions that are held are zero, as commanded, also where a cable is slack.
        """
        simulator = Simulator(self.robot, self.space, self.settings.enrichment)
        report, by_force = simulator.settle_start(), self.robot.actuators.laws.held_by_force
        position = np.where(by_force, simulator.position, 0.0)
        self._origin, self.settled = (simulator.state, simulator.forces, position), report.converged
        self.reset()
        return report

    def start_from(self, state: State, forces: Forces, position: Array) -> None:
        """Start from another state than rest; of another robot or basis a ValueError says so.

        Args:
            state: of the robot.
            forces: constraint forces there, with the columns of this controller's basis [N].
            position: (n_a,) positions of the actuators there [m, m³].
        """
        given = self._checked_start(state, forces, self.space.k, position)
        (self._state, self._forces, position), self.status = given, Status.OK
        self._prepared: Prepared | None = None
        self._decision = self._stepped = None
        self._last_decision: Decision | None = None
        self._pending: Actuation | None = None  # decided in this step
        self._carried, self._course = nothing_carried(self.settings.forces), np.zeros((0, 0))
        self._stalled = np.zeros(self.robot.n_a, np.bool_)
        seen = forces.effort, self.robot.effector(state), self.robot.effector_values(state)
        self._left = Actuation(position, forces.effort, *seen, Status.OK, NO_CERTIFICATE).copy()

    def take_over(self, other: Controller, state: State) -> None:
        """Continue from another controller of the same robot and cables.

        Args:
            other: its forces and actuation are taken; it has the same contact basis.
            state: its state in this one's coordinates.
        """
        self.set_obstacles(other.obstacles)
        self.start_from(state, other._forces, other.position)
        self._left, self.status, self._locks = other.actuation, other.status, other.locks
        self._carried = replace(self._carried, grasp=other.grasp)

    @property
    def effector(self) -> Array:
        """The model's own effector positions: (p, 3) [m]."""
        known = self._prepared and self._prepared.step.rows.effectors  # which has computed them
        return known.positions.copy() if known else super().effector

    @property
    def effector_values(self) -> Array:
        """The model's own goal values of the effectors: (n_v,), see `EffectorLayout`."""
        known = self._prepared and self._prepared.step.rows.effectors
        return known.values.copy() if known else super().effector_values

    def shifted(self, distance: float) -> Array:
        """The effectors' goal values (n_v,) with every row changed by a distance, by its unit [m]."""
        layout = self.robot.effector_layout
        return layout.moved(self.effector_values, distance / layout.units)

    @property
    def actuation(self) -> Actuation:
        """The last actuation: of this step, or of the step before."""
        return (self._pending or self._left).copy()

    @property
    def position(self) -> Array:
        """Positions of the last actuation: (n_a,) [m, m³]."""
        return (self._pending or self._left).position.copy()

    @property
    def effort(self) -> Array:
        """Efforts of the last actuation: (n_a,) [N, Pa]."""
        return (self._pending or self._left).effort.copy()

    @property
    def last_decision(self) -> Decision | None:
        """The last decision for a target, usable or not; None before the first; `write_qpcc` keeps it."""
        return self._last_decision

    def set_obstacles(self, poses: ObstaclePoses) -> None:
        """Have the obstacles in other poses from the next step on that is not decided yet."""
        super().set_obstacles(poses)
        if self._decision is None:
            self._prepared = None

    @one_blas_thread(whole=True)
    def step(self, target: Target) -> Actuation:
        """Prepare, decide and advance: one control step towards a target as of `decide`."""
        actuation = self.decide(target)
        self.advance()
        return actuation

    def prepare(self) -> None:
        """Prepare the next step, unless it is prepared."""
        if self._prepared is not None:
            return
        now = self._state, self._forces, self._left.position, self.settings.enrichment
        robot = self._robot.stepping(self._state, later=self._robot.h)
        ahead = self.horizon.of(robot, self._carried.sight)
        try:
            self._prepared = prepare(ahead, self.space, *now, self._course, self._locks.by_force)
        except FactorisationError:
            self.status = Status.NOT_FINITE

    def decide(self, target: Target, time: TimeLimit | None = None) -> Actuation:
        """Efforts for a target; for one that is not finite the actuators hold, and `status` is the reason.

        Args:
            target: positions (p, 3) or (3 p,) of effectors that are points or centres [m]; of other
                kinds one goal for each effector, a position (3,) [m], a `Pose` or a number, or all goal
                values (n_v,) in a row.
            time: after which plans with friction end with the best that they have; None: no limit.

        Raises:
            ValueError: the target has another shape, or entries that are no numbers; nothing is decided.
        """
        goal = self._robot.effector_layout.goal_values(target)
        self.prepare()
        if goal is None:
            return self._hold(Status.NOT_FINITE)
        if self._prepared is None:
            return self._repeat()
        locks = self._step_locks()
        if locks is not None and (locks.by_position | locks.by_force).all():
            return self._keep(locks, None, goal=goal)
        settings = self.settings if time is None else replace(self.settings, time=time)
        decision = self._last_decision = decide(
            self._robot, self._prepared, goal, self._left.position, settings, locks, self._carried
        )
        status, conflict = decision.status, decision.conflict
        if status.usable and np.logical_and.reduce(np.isfinite(decision.predicted.dv)):
            return self._take(decision, status, conflict)
        return self._hold(Status.NOT_FINITE if status.usable else status, conflict)

    def rehearse(self, target: Target) -> None:
        """Decide for a target without effect: code that ran just before runs faster."""
        goal = self.robot.effector_layout.goal_values(target)
        free = not (self._locks.by_position | self._locks.by_force).all()
        if goal is not None and self._prepared is not None and self._decision is None and free:
            locks, position = self._step_locks(), self._left.position
            decide(self.robot, self._prepared, goal, position, self.settings, locks, self._carried)

    def let_go(self) -> tuple[str, ...]:
        """Set smallest forces and distances to slip aside, until what pushes now has come off.

        A grasp is kept again when contacts push after that. Returns the names of what was kept.
        """
        self._carried = self._carried.letting_go(self.contacts)
        return () if self.grasp is None else self.grasp.released

    @property
    def grasp(self) -> Grasp | None:
        """Limits of contact forces, and which of them count; None where there are none."""
        return self._carried.grasp

    def hold(self) -> Actuation:
        """Keep position or effort of every actuator, as the robot file says; the model moves so."""
        self.prepare()
        return self._hold(None)

    @property
    def locks(self) -> Command:
        """Positions and efforts at which actuators are locked; NaN in both where one is not."""
        return Command(self._locks.position.copy(), self._locks.effort.copy())

    @property
    def stalled(self) -> Bools:
        """Which locked actuators have stopped where more would exceed a limit: (n_a,)."""
        return self._stalled.copy()

    def lock(
        self, actuator: str, position: float | None = None, force: float | None = None
    ) -> None:
        """Lock an actuator; the others are decided. It gets there no faster than its rate allows.

        It moves where targets are decided for, not in a hold. A lock lasts until it is unlocked or `reset`.

        Args:
            actuator: name.
            position: where it is locked [m, m³].
            force: effort at which it is locked [N, Pa]; one of the two is given.

        Raises:
            LockError: no such actuator, not one of position and force, or a value beyond the limits.
        """
        self._relock(locked(self.robot, self._locks, actuator, position, force))

    def unlock(self, actuator: str) -> None:
        """Decide a locked actuator again.

        Raises:
            LockError: no such actuator, or one that is not locked.
        """
        self._relock(unlocked(self.robot, self._locks, actuator))

    def _relock(self, locks: Command) -> None:
        """Decide with other locks; where others are locked at an effort, the step is prepared again."""
        if self._decision is None and (locks.by_force != self._locks.by_force).any():
            self._prepared = None
        self._locks, self._carried = locks, self._carried.undamped()

    def _step_locks(self) -> Command | None:
        """What locked actuators keep in the prepared step; None: none is locked."""
        if self._prepared is None:
            return None
        left, change = self._left, self._robot.h * self._robot.limits.rate
        return locks_of_step(self._locks, left.position, left.effort, self._prepared.step, change)

    def limit(self, actuation: Actuation) -> None:
        """Replace this step's actuation by the one that left, which a limiter may have changed."""
        if self._decision is None:
            self._left = actuation.copy()
        else:
            self._pending = actuation.copy()

    def advance(self) -> None:
        """Move the model by what was decided."""
        made, now = self._decision, self._pending
        if made is None or now is None:
            return
        self._robot = self._robot.later(self._robot.h)
        try:
            self._state, self._forces, solved = advance(
                self._robot, self.space, self.settings, made, self._left, now
            )
        except FactorisationError:
            self.status = Status.NOT_FINITE
        else:
            self._stepped, self._stalled = (self._state, solved), made.stalled
            grasp, carried = self._carried.grasp, made.carried or self._carried
            after = None if grasp is None else grasp.after(self.contacts)
            self._carried = carried if after is None else replace(carried, grasp=after)
            self._course = with_goal(self._course, made.goal, self.horizon.ticks)
        self._left, self._pending, self._prepared, self._decision = now, None, None, None

    def _hold(self, status: Status | None, conflict: tuple[str, ...] = ()) -> Actuation:
        """Hold the actuators, after a decision that failed with this status; None: no decision failed."""
        return self._keep(resting(self._locks, self._left.position), status, conflict)

    def _keep(
        self, locks: Command, status: Status | None, conflict: tuple[str, ...] = (), goal: Array | None = None
    ) -> Actuation:  # fmt: skip
        """A step in which locked actuators go where `locks` says and others are held, whatever the goal."""
        if self._prepared is None:
            return self._repeat()
        left, enrichment = self._left, self.settings.enrichment
        held = with_locks(self.robot.actuators.laws.held(left.position, left.effort), locks)
        decision = hold(self.robot, self._prepared, held, left.position, enrichment, goal)
        if not np.isfinite(decision.predicted.dv).all():
            return self._repeat()
        if status is None:
            status, conflict = decision.status, decision.conflict
            if status.ok and (names := self._carried.exceeded(decision.predicted, self.space)):
                status, conflict = Status.RELAXED, names  # nothing is decided that could keep them
        return self._take(decision, status, conflict)

    def _take(self, decision: Decision, status: Status, conflict: tuple[str, ...]) -> Actuation:
        """Make a decision this step's."""
        self._decision, self.status = decision, status
        self._pending = decided_actuation(self._robot, decision, status, conflict)
        return self._pending.copy()

    def _repeat(self) -> Actuation:
        """The last actuation again, for a model that cannot be stepped any more."""
        self.status, self._decision, self._pending = Status.NOT_FINITE, None, None
        self._left = Actuation(
            position=self._left.position,
            effort=self._left.effort,
            needed=self._left.needed,
            effector=self.effector,
            effector_values=self.effector_values,
            status=Status.NOT_FINITE,
            certificate=NO_CERTIFICATE,
            conflict=unknown_rows(self._robot, self._robot.rows(self._state)),
        )
        self._prepared = None  # what an extension gives may be finite in the next one
        return self._left.copy()
