"""Controller, guard and state machine together: what leaves at each tick, without time or network.

The node and the replay run the same loop; the node gives it what Zenoh brought, the replay what a
log says.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tauten.controller import NOTHING, Actuation, Controller
from tauten.controller.qpcc import Certificate, Status
from tauten.model.numerics import Array
from tauten.service.node.limiter import ActuationLimiter, LimitedActuation
from tauten.service.node.state_machine import NodeState, Signals, commanded, judged, transition
from tauten.service.wire import Cause, Mode, OperatorCommand


@dataclass(frozen=True, slots=True)
class Action:
    """What leaves at a tick.

    Attributes:
        mode: what the loop is doing.
        cause: why it does not follow.
        pull: (n_a,) pulled lengths [m].
        tension: (n_a,) tensions [N].
        effector: (p, 3) where the model's effectors will be after the tick [m].
        status: of the decision; None when nothing was decided.
        certificate: of the decision, or of the hold.
        clamped: whether the guard changed the actuation.
    """

    mode: Mode
    cause: Cause
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
        state: of the state machine.
    """

    def __init__(self, controller: Controller, enabled: bool = True) -> None:
        """Start at rest, with a controller that is there too.

        Args:
            controller: the model.
            enabled: whether targets are followed before an operator says so.
        """
        robot = controller.robot
        self.controller = controller
        self.guard = ActuationLimiter(robot.limits, robot.h)
        rest = self.guard.rest()
        self.guard(rest.pull, rest.tension)  # its kernels are compiled now, not at the first tick
        self.state = NodeState(enabled=enabled)
        self._settings = robot.config.service
        self._ramp: Iterator[LimitedActuation] | None = None

    @property
    def released(self) -> bool:
        """Whether a stop has let the cables go."""
        last, rest = self.guard.last, self.guard.rest()
        slack = (last.pull == rest.pull).all() and (last.tension == rest.tension).all()
        return self._ramp is not None and bool(slack)

    def command(self, command: OperatorCommand) -> bool:
        """Take an operator's command; False where it is not possible now."""
        found = commanded(self.state, command, self.released)
        if found is None:
            return False
        if command is OperatorCommand.RESET:
            self.rest()
        self.state = found
        return True

    def tick(self, goal: Array | None, seen: Signals) -> Action:
        """One tick: where the state machine goes, and what leaves.

        Args:
            goal: (p, 3) positions asked of the model [m]; None: nothing to follow.
            seen: what the tick has seen.
        """
        self.state = transition(self.state, seen, self._settings.late_limit)
        return self.act(goal)

    def act(self, goal: Array | None) -> Action:
        """What leaves in the state the loop is in."""
        if self.state.mode is Mode.STOP:
            return self._release()
        self._ramp = None
        if self.state.mode is not Mode.RUN or goal is None:
            return self._guarded(self.controller.hold(), None)
        actuation = self.controller.decide(goal)
        self.state = judged(self.state, actuation.status.usable)
        return self._guarded(actuation, actuation.status)

    def rehearse(self, goal: Array) -> None:
        """Go through a decision that may be asked for at the next tick: (p, 3) [m]; nothing comes of it."""
        if self.state.mode is Mode.RUN:
            self.controller.rehearse(goal)

    def prepare(self) -> None:
        """Move the model by the decision taken and make the next one ready."""
        if self.state.mode is not Mode.STOP:
            self.controller.advance()
            self.controller.prepare()

    def take_over(self, controller: Controller) -> None:
        """Go on with another controller, which has taken over from this one at a time step of its own."""
        last = self.guard.last
        self.controller = controller
        self.guard = ActuationLimiter(controller.robot.limits, controller.robot.h)
        self.guard.last = last
        self._ramp = None

    def rest(self) -> None:
        """The model back to rest, where a release has left the robot."""
        self.controller.reset()
        self._ramp = None

    def _release(self) -> Action:
        """Let the cables go in a straight ramp within the rate limits, then keep them slack."""
        if self._ramp is None:
            self._ramp = self.guard.release(self._settings.release_time)
        safe = next(self._ramp, None)
        if safe is None:  # asked for again: rounding may have left the last step a hair short
            rest = self.guard.rest()
            safe = self.guard(rest.pull, rest.tension)
        state = self.state
        return Action(
            state.mode, state.cause, safe.pull, safe.tension, self.controller.effector,
            None, NOTHING, safe.clamped,
        )  # fmt: skip

    def _guarded(self, actuation: Actuation, status: Status | None) -> Action:
        safe = self.guard(actuation.pull, actuation.tension)
        state = self.state
        return Action(
            state.mode, state.cause, safe.pull, safe.tension, actuation.effector,
            status, actuation.certificate, safe.clamped,
        )  # fmt: skip
