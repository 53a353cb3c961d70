"""The controller: a model of the robot that follows targets and computes the actuation of its cables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tauten.controller.qpcc import Certificate, QpccSettings, Status
from tauten.controller.settings import ControllerSettings
from tauten.controller.step import (
    DecideSettings,
    Decision,
    Prepared,
    advance,
    decide,
    hold,
    prepare,
)
from tauten.model import (
    ContactSpace,
    Enrichment,
    Forces,
    Robot,
    State,
    contact_model,
    default_enrichment,
    no_forces,
)
from tauten.model.numerics import Array, FactorisationError

NO_CERTIFICATE = Certificate(np.nan, np.nan, np.nan, np.nan)  # nothing was solved


@dataclass(frozen=True, slots=True)
class Actuation:
    """Pulled lengths and tensions of the cables, and their certificate.

    Attributes:
        pull: (n_a,) pulled lengths [m].
        tension: (n_a,) tensions [N].
        effector: (p, 3) predicted positions of the effectors [m].
        status: how the decision or the hold ended; where it is not usable, the pulled lengths are held.
        certificate: residuals and deepest predicted gap.
        conflict: names of the limits that conflict.
        clamped: whether a limiter changed pulled lengths or tensions.
    """

    pull: Array
    tension: Array
    effector: Array
    status: Status
    certificate: Certificate
    conflict: tuple[str, ...] = ()
    clamped: bool = False

    def with_values(self, pull: Array, tension: Array, clamped: bool) -> Actuation:
        """The same actuation with other values.

        Args:
            pull: (n_a,) pulled lengths [m].
            tension: (n_a,) tensions [N].
            clamped: whether a limiter changed them.
        """
        return Actuation(
            pull, tension, self.effector, self.status, self.certificate, self.conflict, clamped
        )

    def copy(self) -> Actuation:
        """The same actuation in arrays of its own."""
        return Actuation(
            self.pull.copy(), self.tension.copy(), self.effector.copy(), self.status,
            self.certificate, self.conflict, self.clamped,
        )  # fmt: skip


class Controller:
    """Inverse control of a robot, one decision a time step. Arrays that it returns are copies.

    `step` does all of it; a node calls `decide` at the tick, publishes, and then `advance` and `prepare`,
    so that the next step is ready before its target arrives. Between two calls of `advance` the last
    `decide` or `hold` counts, and each starts from the pulled lengths that left in the step before.

    Attributes:
        robot: the robot, with a factorisation of its own.
        space: basis of its contact forces.
        settings: of its decisions.
        status: how the last prepare, decide or hold ended.
    """

    def __init__(
        self,
        robot: Robot,
        contact: Literal["none", "full"] | ContactSpace = "none",
        enrichment: Enrichment | None = None,
        settings: ControllerSettings | None = None,
    ) -> None:
        """Start at rest.

        Args:
            robot: what to control; the controller makes a workspace of its own.
            contact: "none"; "full", pointwise; or a basis of contact forces.
            enrichment: when unit columns join a basis; default: at the robot's tolerance, in at
                most three rounds.
            settings: of the inverse problem; default: those of a robot file that does not set any. See
                `load_controller_settings`.

        Raises:
            ValueError: `contact` is none of these, or a basis of another robot's size.
        """
        reduced = default_enrichment(robot.tolerance)
        self.space, default = contact_model(contact, robot.n_c, reduced)
        self.robot = robot.fork()
        settings = settings or ControllerSettings()
        self.settings = DecideSettings(
            epsilon=settings.regularisation,
            enrichment=enrichment or default,
            qpcc=QpccSettings(solver=settings.qp_solver, max_pivots=settings.max_pivots),
        )
        self.reset()

    def reset(self) -> None:
        """Return to rest, without forces."""
        robot = self.robot
        self._start(robot.rest(), no_forces(robot.n_a, self.space.k), np.zeros(robot.n_a))

    def start_from(self, state: State, forces: Forces, pull: Array) -> None:
        """Start from another state than rest.

        Args:
            state: of the robot.
            forces: constraint forces there, with the columns of this controller's basis [N].
            pull: (n_a,) pulled lengths there [m].
        """
        self._start(state.copy(), forces.copy(), pull.copy())

    def _start(self, state: State, forces: Forces, pull: Array) -> None:
        self._state, self._forces, self.status = state, forces, Status.OK
        self._prepared: Prepared | None = None
        self._decision: Decision | None = None
        self._last_decision: Decision | None = None
        self._pending: Actuation | None = None  # decided in this step
        self._left = Actuation(  # in the step before: what rates and holds start from
            pull, forces.tension, self.robot.effector(state), Status.OK, NO_CERTIFICATE
        )

    def take_over(self, other: Controller, state: State) -> None:
        """Continue from another controller of the same robot and cables.

        Args:
            other: its forces and actuation are taken; it has the same contact basis.
            state: its state in this one's coordinates.
        """
        self.start_from(state, other._forces, other.pull)
        self._left, self.status = other.actuation, other.status

    @property
    def state(self) -> State:
        """Configuration and velocity of the model."""
        return self._state.copy()

    @property
    def forces(self) -> Forces:
        """Constraint forces of the last step."""
        return self._forces.copy()

    @property
    def effector(self) -> Array:
        """The model's own effector positions: (p, 3) [m]."""
        if self._prepared is not None:  # which has computed them
            return self._prepared.step.rows.effectors.delta.reshape(-1, 3).copy()
        return self.robot.effector(self._state).copy()

    @property
    def actuation(self) -> Actuation:
        """The last actuation: of this step, or of the step before."""
        return (self._pending or self._left).copy()

    @property
    def pull(self) -> Array:
        """Pulled lengths of the last actuation: (n_a,) [m]."""
        return (self._pending or self._left).pull.copy()

    @property
    def tension(self) -> Array:
        """Tensions of the last actuation: (n_a,) [N]."""
        return (self._pending or self._left).tension.copy()

    @property
    def last_decision(self) -> Decision | None:
        """The last decision for a target, usable or not; None before the first.

        `tauten.controller.qpcc.write_qpcc` writes its `problem` and `start` to a file for `tauten solve`.
        """
        return self._last_decision

    @property
    def candidates_in_range(self) -> int:
        """Contact candidates within the alarm distance in the prepared step."""
        return 0 if self._prepared is None else len(self._prepared.step.rows.contacts)

    def step(self, target: Sequence[float] | Array) -> Actuation:
        """Prepare, decide and advance: one control step towards a target (3,) or (p, 3) [m]."""
        actuation = self.decide(target)
        self.advance()
        return actuation

    def prepare(self) -> None:
        """Prepare the next step, unless it is prepared."""
        if self._prepared is not None:
            return
        try:
            self._prepared = prepare(
                self.robot, self.space, self._state, self._forces, self.settings.enrichment
            )
        except FactorisationError:
            self.status = Status.NOT_FINITE

    def decide(self, target: Sequence[float] | Array) -> Actuation:
        """Tensions for a target. A bad target raises nothing: the cables hold, and `status` is the reason.

        Args:
            target: (p, 3) or (3 p,) positions of the effectors [m].
        """
        goal = self._goal(target)
        self.prepare()
        if goal is None:
            return self._hold(Status.NOT_FINITE)
        if self._prepared is None:
            return self._repeat()
        decision = decide(self.robot, self._prepared, goal, self._left.pull, self.settings)
        self._last_decision = decision
        if not decision.status.usable:
            return self._hold(decision.status, decision.conflict)
        return self._take(decision, None, decision.status, decision.conflict)

    def rehearse(self, target: Array) -> None:
        """Decide for a target (p, 3) [m] without effect: code that ran just before runs faster."""
        if self._prepared is not None and self._decision is None:
            decide(self.robot, self._prepared, target.ravel(), self._left.pull, self.settings)

    def hold(self) -> Actuation:
        """Keep the winches where they are; the model moves as a robot with held cables does."""
        self.prepare()
        return self._hold(None)

    def limit(self, actuation: Actuation) -> None:
        """Replace this step's actuation by the one that left, which a limiter may have changed."""
        if self._decision is None:
            self._left = actuation.copy()
        else:
            self._pending = actuation.copy()

    def advance(self) -> None:
        """Move the model by what was decided."""
        if self._decision is None or self._pending is None:
            return
        predicted = self._decision.predicted
        self._state = advance(self.robot, predicted)
        self._forces = predicted.step.split(predicted.lam, self.space.k)
        self._left, self._pending = self._pending, None
        self._prepared = self._decision = None

    def _goal(self, target: Sequence[float] | Array) -> Array | None:
        """Target positions (n_e,) [m]; None: not as many finite numbers."""
        n_e = self.robot.n_e
        try:
            goal = np.asarray(target, dtype=float)
        except (TypeError, ValueError, OverflowError):
            return None
        if goal.shape not in ((n_e // 3, 3), (n_e,)) or not np.isfinite(goal).all():
            return None
        return goal.ravel()

    def _hold(self, status: Status | None, conflict: tuple[str, ...] = ()) -> Actuation:
        """Hold the winches, after a decision that failed with this status; None: no decision failed."""
        if self._prepared is None:
            return self._repeat()
        pull = self._left.pull
        decision = hold(self.robot, self._prepared, pull, self.settings.enrichment)
        if not np.isfinite(decision.predicted.dv).all():
            return self._repeat()
        if status is None:
            status, conflict = decision.status, decision.conflict
        # the winches do not turn, even where a slack cable's path is shorter than what they let out
        return self._take(decision, pull, status, conflict)

    def _take(
        self, decision: Decision, held: Array | None, status: Status, conflict: tuple[str, ...]
    ) -> Actuation:
        """Make a decision this step's; pulled lengths (n_a,) [m] are the held ones or the predicted."""
        n_e, cables = self.robot.n_e, slice(self.robot.n_e, self.robot.n_e + self.robot.n_a)
        delta = decision.predicted.delta
        self._decision, self.status = decision, status
        self._pending = Actuation(
            pull=delta[cables] if held is None else held,
            tension=decision.predicted.lam[cables],
            effector=delta[:n_e].reshape(-1, 3),
            status=status,
            certificate=decision.certificate,
            conflict=conflict,
        )
        return self._pending.copy()

    def _repeat(self) -> Actuation:
        """The last actuation again, for a model that cannot be stepped any more."""
        self.status, self._decision, self._pending = Status.NOT_FINITE, None, None
        left = self._left
        self._left = Actuation(
            left.pull, left.tension, self.effector, Status.NOT_FINITE, NO_CERTIFICATE
        )
        return self._left.copy()
