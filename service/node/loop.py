"""Controller, limiter and state machine together: the actuation of each tick, without clock or network.

The node and the replay run the same loop; the node passes it what Zenoh brought, the replay what a
log contains.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from tauten.controller import NO_CERTIFICATE, Actuation, Controller, LockError
from tauten.controller.qpcc import Status, TimeLimit
from tauten.model.contact import ObstaclePose
from tauten.model.numerics import Array
from tauten.service.node.limiter import ActuationLimiter
from tauten.service.node.state_machine import NodeState, Signals, commanded, judged, transition
from tauten.service.settings import ServiceSettings
from tauten.service.wire import (
    Cause,
    Diagnostic,
    Level,
    LockOrder,
    Mode,
    OperatorCommand,
    OperatorOrder,
    Rejection,
    RejectionReason,
    quoted,
)

log = logging.getLogger(__name__)

_NOTHING: Mapping[str, ObstaclePose] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Action:
    """The result of a tick.

    Attributes:
        mode: of the state machine.
        cause: why it does not follow.
        decided: whether a target was decided for.
        wanted: actuation of the model or of the release, before the limits.
        actuation: what leaves, within the limits.
        checks: of the time that were passed by a decision which was cut; −1: it was not.
    """

    mode: Mode
    cause: Cause
    decided: bool
    wanted: Actuation
    actuation: Actuation
    checks: int = -1

    @property
    def status(self) -> Status | None:
        """How the decision ended; None where no target was decided for. Holds have `wanted.status`."""
        return self.wanted.status if self.decided else None


class ControlLoop:
    """Decides, limits, holds and releases.

    Attributes:
        controller: the model that follows. It keeps what left last.
        state: of the state machine.
    """

    def __init__(
        self,
        controller: Controller,
        enabled: bool = True,
        settings: ServiceSettings | None = None,
        timed: bool = False,
    ) -> None:
        """Start at rest, with a controller that is at rest too.

        Args:
            controller: the model.
            enabled: whether targets are followed before an operator enables it.
            settings: limit of missed deadlines and time of a release; default: those of a file that
                does not set any.
            timed: whether decisions with friction end after a share of the period on the clock.
        """
        self.state = NodeState(enabled=enabled)
        self._settings = settings or ServiceSettings()
        self._share = self._settings.decision_share if timed else math.inf
        self.take_over(controller)

    def take_over(self, controller: Controller) -> None:
        """Continue with another controller, which has taken over from this one, at its own time step."""
        robot = controller.robot
        self.controller = controller
        self._within = self._share * robot.h
        self._limiter = ActuationLimiter(robot.limits, robot.h)
        last = controller.actuation
        self._limiter.limit(last, last)  # compiles its kernels now, not at the first tick
        self._ramp: Iterator[Actuation] | None = None
        self._hurried = False  # whether the ramp is as fast as the rate limits permit

    @property
    def released(self) -> bool:
        """Whether a stop has slackened the cables."""
        return self._ramp is not None and self._limiter.at_rest(self.controller.actuation)

    def obey(self, order: OperatorOrder) -> Rejection | None:
        """Carry out an operator's order; what is not possible is refused with the reason."""
        if isinstance(order, LockOrder):
            return self._obey_lock(order)
        if self.command(order):
            return None
        why = "there was no stop"
        if self.state.mode is Mode.STOP:
            reset = order is OperatorCommand.RESET
            why = (
                "the actuators are still being released"
                if reset
                else "it has stopped, reset it first"
            )
        return Rejection(RejectionReason.NOT_NOW, f"{order} is not possible now: {why}")

    def _obey_lock(self, order: LockOrder) -> Rejection | None:
        """Lock or unlock an actuator; a stop releases all of them, and none is locked in it.

        Where the node does not follow, a lock waits: it moves its actuator from the next `Mode.RUN` on.
        """
        if self.state.mode is Mode.STOP:
            return Rejection(RejectionReason.NOT_NOW, f"{quoted(order)} is not possible in a stop")
        try:
            if order.moves:
                self.controller.lock(order.actuator, order.position, order.force)
            else:
                self.controller.unlock(order.actuator)
        except LockError as error:
            return Rejection(RejectionReason.LOCK_REFUSED, str(error))
        return None

    def command(self, command: OperatorCommand) -> bool:
        """Obey an operator's command; False where it is not possible now."""
        found = commanded(self.state, command, self.released)
        if found is None:
            return False
        if command is OperatorCommand.RESET:
            self.rest()
        elif command is OperatorCommand.LET_GO:
            names = self.controller.let_go()
            log.info("let go: %s", ", ".join(names) or "nothing was grasped")
        self.state = found
        return True

    @property
    def locks(self) -> Diagnostic:
        """Which actuators are locked, and where, and which have stopped at a limit, for health."""
        locks, actuators = self.controller.locks, self.controller.robot.actuators
        stalled, position = self.controller.stalled, self.controller.position
        values = {}
        for i, (name, kind) in enumerate(zip(actuators.names, actuators.kinds, strict=True)):
            if locks.by_position[i]:
                values[name] = f"{kind.position.name} {locks.position[i]:g} {kind.position.unit}"
                if stalled[i]:
                    values[name] += (
                        f", stopped at {position[i]:g} {kind.position.unit} by its limits of "
                        f"{kind.effort.name}"
                    )
            elif locks.by_force[i]:
                values[name] = f"{kind.effort.name} {locks.effort[i]:g} {kind.effort.unit}"
        text = "; ".join(f"{name} at {what}" for name, what in values.items())
        level = Level.WARN if stalled.any() else Level.OK
        return Diagnostic("locks", level, text or "none", values)

    def set_mode(self, mode: Mode, cause: Cause) -> None:
        """Set the state that a recorded tick was in, for a replay."""
        self.state = replace(self.state, mode=mode, cause=cause)

    def tick(self, goal: Array | None, seen: Signals) -> Action:
        """One tick: a transition of the state machine by what was seen in it, then its action, see `act`."""
        self.state = transition(self.state, seen, self._settings.late_limit)
        return self.act(goal)

    def act(self, goal: Array | None, checks: int = -1) -> Action:
        """The action in the present state for goal values (n_v,) of the model; None: nothing to follow.

        With the checks of an action whose decision was cut this one is cut there too.
        """
        last, decided = self.controller.actuation, False
        time = TimeLimit(self._within) if checks < 0 else TimeLimit(checks=checks)
        if self.state.mode is Mode.STOP:
            wanted = self._release()
        elif self.state.mode is Mode.RUN and goal is not None:
            self._ramp, decided = None, True
            wanted = self.controller.decide(goal, time)
            self.state = judged(self.state, wanted.status.usable)
        else:
            self._ramp = None
            wanted = self.controller.hold()
        actuation = self._limiter.limit(wanted, last)
        self.controller.limit(actuation)
        mode, cause = self.state.mode, self.state.cause
        return Action(mode, cause, decided, wanted, actuation, time.repeats)

    def rehearse(self, goal: Array) -> None:
        """Go through a decision that the next tick may need, for goal values (n_v,), without effect."""
        if self.state.mode is Mode.RUN:
            self.controller.rehearse(goal)

    def prepare(self, placed: Mapping[str, ObstaclePose] = _NOTHING) -> None:
        """Move the model by the decision taken and prepare the next step.

        Obstacles may be placed, by name, elsewhere after the step than the model has them.
        """
        controller, stopped = self.controller, self.state.mode is Mode.STOP
        if not stopped:
            controller.advance()
        for name, pose in placed.items():
            controller.set_obstacles(controller.obstacles.with_pose(name, pose))
        if not stopped:
            controller.prepare()

    def rest(self) -> None:
        """Reset the model to rest, where a release has left the robot; obstacles stay where they are."""
        seen = self.controller.obstacles
        self.controller.reset()
        self.controller.set_obstacles(self.controller.obstacles.with_given(seen))
        self._ramp = None

    def _release(self) -> Actuation:
        """Slacken the cables in a straight ramp within the rate limits, then keep them slack.

        A ramp that is hurried begins anew from where the cables are.
        """
        hurried = self.state.cause is Cause.HURRIED
        if self._ramp is None or hurried is not self._hurried:
            last, self._hurried = self.controller.actuation, hurried
            start = Actuation(
                last.position, last.effort, last.effort, last.effector, last.effector_values,
                Status.OK, NO_CERTIFICATE,
            )  # fmt: skip
            seconds = 0.0 if hurried else self._settings.release_time
            self._ramp = self._limiter.release(start, seconds)
        return next(self._ramp)
