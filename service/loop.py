"""Controller, guard and mode together: what leaves at each tick, without time or network.

The node and the replay run the same loop; the node gives it goals from Zenoh, the replay from a
log.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tauten.controller.controller import NOTHING, Actuation, Controller
from tauten.controller.solution import Certificate, Status
from tauten.model.arrays import Array
from tauten.service.guard import Guard
from tauten.service.tick import Mode


@dataclass(frozen=True, slots=True)
class Action:
    """What leaves at a tick.

    Attributes:
        mode: what the loop is doing.
        pull: (n_a,) pulled lengths [m].
        tension: (n_a,) tensions [N].
        effector: (p, 3) where the model's effectors will be after the tick [m].
        status: of the decision; None when nothing was decided.
        certificate: of the decision, or of the hold.
        clamped: whether the guard changed the actuation.
    """

    mode: Mode
    pull: Array
    tension: Array
    effector: Array
    status: Status | None
    certificate: Certificate
    clamped: bool


class ControlLoop:
    """Decides, guards, holds and releases.

    Attributes:
        controller: the model that follows.
        guard: the last clamp.
        mode: what the loop is doing.
    """

    def __init__(self, controller: Controller) -> None:
        """Start at rest, with a controller that is there too."""
        robot = controller.robot
        self.controller = controller
        self.guard = Guard(robot.limits, robot.h)
        self.mode = Mode.IDLE

    def decide(self, goal: Array | None) -> Action:
        """What leaves now.

        Args:
            goal: (p, 3) positions [m]; None: the winches stand still.
        """
        if goal is None:
            self.mode = Mode.IDLE if self.mode is Mode.IDLE else Mode.HOLD
            return self._guarded(self.controller.hold(), None)
        actuation = self.controller.decide(goal)
        self.mode = Mode.RUN if actuation.status.usable else Mode.HOLD
        return self._guarded(actuation, actuation.status)

    def prepare(self) -> None:
        """Move the model by the decision taken and make the next one ready."""
        self.controller.advance()
        self.controller.prepare()

    def release(self, release_time: float) -> Iterator[Action]:
        """Actions that let the cables go, tick by tick, in a straight ramp within the rate limits.

        Args:
            release_time: seconds it takes at least.
        """
        self.mode = Mode.STOP
        start, rest, h = self.guard.last, self.guard.rest(), self.controller.robot.h
        steps = self.guard.release_steps(release_time, h)
        for step in range(1, steps + 1):
            left = 1.0 - step / steps
            safe = self.guard(
                rest.pull + left * (start.pull - rest.pull),
                rest.tension + left * (start.tension - rest.tension),
            )
            effector = self.controller.effector
            yield Action(self.mode, safe.pull, safe.tension, effector, None, NOTHING, safe.clamped)

    def _guarded(self, actuation: Actuation, status: Status | None) -> Action:
        safe = self.guard(actuation.pull, actuation.tension)
        return Action(
            self.mode, safe.pull, safe.tension, actuation.effector,
            status, actuation.certificate, safe.clamped,
        )  # fmt: skip
