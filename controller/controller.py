"""The controller: a model of the robot that follows targets and says what its cables must do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tauten.controller.qpcc import Certificate, QpccSettings, Status
from tauten.controller.step import (
    DecideSettings,
    Decision,
    Prepared,
    advance,
    decide,
    forces_of,
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

NOTHING = Certificate(np.nan, np.nan, np.nan, np.nan)


@dataclass(frozen=True, slots=True)
class Actuation:
    """What the cables are to do, and how far to trust it.

    Attributes:
        pull: (n_a,) pulled lengths [m].
        tension: (n_a,) tensions [N].
        status: how the decision ended; where it is not usable, the pulled lengths are held.
        certificate: residuals and deepest predicted gap of the decision.
        effector: (p, 3) predicted positions of the effectors [m].
    """

    pull: Array
    tension: Array
    status: Status
    certificate: Certificate
    effector: Array


class Controller:
    """Inverse control of a robot, one decision a time step.

    `step` does all of it; a node calls `decide` when the tick comes, publishes, and then `advance` and
    `prepare`, so that the next decision is ready before its target.

    Attributes:
        robot: the robot, with a factorisation of its own.
        space: where its contact forces live.
        settings: of its decisions.
        state: configuration and velocity of the model.
        forces: constraint forces of the last decision.
        status: how the last prepare or decide ended.
    """

    def __init__(
        self,
        robot: Robot,
        contact: Literal["none", "full"] | ContactSpace = "none",
        enrichment: Enrichment | None = None,
    ) -> None:
        """Start at rest.

        Args:
            robot: what to control; the caller's workspace is left alone.
            contact: "none"; "full", pointwise; or a basis of contact forces.
            enrichment: when unit columns join a basis; default: at the robot file's tolerance, in at
                most three rounds.

        Raises:
            ValueError: `contact` is none of these, or a basis of another robot's size.
        """
        reduced = default_enrichment(robot.config.contact.tolerance)
        self.space, default = contact_model(contact, robot.n_c, reduced)
        self.robot = robot.fork()
        settings = robot.config.controller
        self.settings = DecideSettings(
            epsilon=settings.regularisation,
            enrichment=enrichment or default,
            qpcc=QpccSettings(solver=settings.qp_solver, max_pivots=settings.max_pivots),
        )
        self.reset()

    def reset(self) -> None:
        """Back to rest, no forces."""
        robot = self.robot
        self.state: State = robot.rest()
        self.forces = no_forces(robot.n_a, self.space.k)
        self.status = Status.OK
        self._prepared: Prepared | None = None
        self._decision: Decision | None = None
        self._actuation = Actuation(
            np.zeros(robot.n_a), np.zeros(robot.n_a), Status.OK, NOTHING, self.effector
        )

    @property
    def effector(self) -> Array:
        """The model's own effector positions: (p, 3) [m]."""
        if self._prepared is not None:  # which has looked for them where the model is
            return self._prepared.rows.effectors.delta.reshape(-1, 3)
        return self.robot.effector(self.state)

    @property
    def pull(self) -> Array:
        """Pulled lengths commanded last: (n_a,) [m]."""
        return self._actuation.pull

    @property
    def tension(self) -> Array:
        """Tensions commanded last: (n_a,) [N]."""
        return self._actuation.tension

    @property
    def sees_contact(self) -> bool:
        """Whether contact is looked for at all."""
        return self.space.k > 0 or self.settings.enrichment.rounds > 0

    @property
    def candidates_in_range(self) -> int:
        """Contact candidates within the alarm distance in the prepared step."""
        return 0 if self._prepared is None else len(self._prepared.rows.contacts)

    def prepare(self) -> None:
        """Get the next step ready; does nothing when it already is."""
        if self._prepared is not None:
            return
        try:
            self._prepared = prepare(
                self.robot, self.space, self.state, self.forces, self.settings.enrichment
            )
        except FactorisationError:
            self.status = Status.NOT_FINITE

    def decide(self, target: Sequence[float] | Array) -> Actuation:
        """Tensions for a target; never raises on a bad one, but holds and says why in the status.

        Args:
            target: (3,) or (p, 3) positions of the effectors [m].
        """
        try:
            goal = np.asarray(target, dtype=float).ravel()
        except (TypeError, ValueError):
            goal = np.zeros(0)
        if goal.shape != (self.robot.n_e,) or not np.isfinite(goal).all():
            return self._hold(Status.NOT_FINITE)
        self.prepare()
        if self._prepared is None:
            return self._stand(Status.NOT_FINITE)
        decision = decide(self.robot, self._prepared, goal, self.pull, self.forces, self.settings)
        if not decision.solution.status.usable:
            return self._hold(decision.solution.status)
        return self._take(decision, decision.solution.status)

    def rehearse(self, target: Array) -> None:
        """Decide for a target (p, 3) [m] and forget it: a processor is fast at what it has just done."""
        if self._prepared is not None and self._decision is None:
            goal = target.ravel()
            decide(self.robot, self._prepared, goal, self.pull, self.forces, self.settings)

    def hold(self) -> Actuation:
        """Keep the winches where they are; the model moves as a robot with held cables does."""
        return self._hold(Status.OK)

    def advance(self) -> None:
        """Move the model by what was decided."""
        if self._decision is None:
            return
        self.state = advance(self.robot, self._decision)
        self.forces = forces_of(self.robot, self.space, self._decision)
        self._prepared = self._decision = None

    def start_from(self, state: State, forces: Forces, pull: Array) -> None:
        """Start somewhere else than at rest.

        Args:
            state: of the robot.
            forces: constraint forces there, with the columns of this controller's basis.
            pull: (n_a,) pulled lengths there [m].
        """
        self.reset()
        self.state, self.forces = state, forces
        self._actuation = replace(
            self._actuation, pull=pull, tension=forces.tension, effector=self.effector
        )

    def take_over(self, other: Controller, state: State) -> None:
        """Go on from where another controller of the same robot and cables is.

        Args:
            other: where forces and actuation are taken from; it has the same contact basis.
            state: its state in this one's coordinates.
        """
        self.state, self.forces, self.status = state, other.forces, other.status
        self._actuation = other._actuation
        self._prepared = self._decision = None

    def step(self, target: Sequence[float] | Array) -> Actuation:
        """Prepare, decide and advance: one control step towards a target (3,) or (p, 3) [m]."""
        actuation = self.decide(target)
        self.advance()
        return actuation

    def _hold(self, status: Status) -> Actuation:
        self.prepare()
        if self._prepared is None:
            return self._stand(Status.NOT_FINITE)
        decision = hold(self.robot, self._prepared, self.pull, self.settings.enrichment)
        if not np.isfinite(decision.dv).all():
            return self._stand(Status.NOT_FINITE)
        # the winches have not moved, even where a slack cable's path is shorter than what they let out
        pull = self.pull
        self._actuation = replace(self._take(decision, status), pull=pull)
        return self._actuation

    def _take(self, decision: Decision, status: Status) -> Actuation:
        n_e, n_a = self.robot.n_e, self.robot.n_a
        self._decision, self._prepared, self.status = decision, decision.prepared, status
        self._actuation = Actuation(
            pull=decision.delta[n_e : n_e + n_a],
            tension=decision.solution.lam_a,
            status=status,
            certificate=decision.certificate,
            effector=decision.delta[:n_e].reshape(-1, 3),
        )
        return self._actuation

    def _stand(self, status: Status) -> Actuation:
        """The last actuation again, for a model that cannot be stepped any more."""
        self.status, self._decision = status, None
        self._actuation = replace(
            self._actuation, status=status, certificate=NOTHING, effector=self.effector
        )
        return self._actuation
