"""Modes of the node, causes for not following, and commands of an operator, with their names on the wire."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Mode(StrEnum):
    """Modes of the node."""

    IDLE = "idle"  # at rest, nothing followed yet
    RUN = "run"  # following targets
    HOLD = "hold"  # winches do not move
    STOP = "stop"  # cables are released, then slack until a reset


class Cause(StrEnum):
    """Why the node does not follow; the value is the text in health and ticks."""

    NONE = ""
    NO_TARGET = "no target"
    OPERATOR = "operator"
    LATE = "deadlines missed"
    UNMEASURED = "no measurement"
    IMPLAUSIBLE = "measurement not plausible"
    UNUSABLE = "decision not usable"
    SHUTDOWN = "shutting down"
    HURRIED = "shutting down fast"  # after a second request to stop


class OperatorCommand(StrEnum):
    """Commands of an operator."""

    ENABLE = "enable"  # follow targets again
    HOLD = "hold"  # do not move the winches until enabled
    STOP = "stop"  # release the cables
    RESET = "reset"  # from a finished stop back to idle
    LET_GO = "let-go"  # smallest forces do not count until what pushes now has come off


@dataclass(frozen=True, slots=True)
class LockOrder:
    """An operator's order to lock an actuator, or to unlock it.

    Attributes:
        actuator: name.
        position: where it is locked [m, m³, rad]; None: its effort is, or it is unlocked.
        force: effort at which it is locked [N, Pa, N m]; None where `position` is given or it is unlocked.
    """

    actuator: str
    position: float | None = None
    force: float | None = None

    @property
    def moves(self) -> bool:
        """Whether it locks an actuator, rather than unlocks it."""
        return self.position is not None or self.force is not None

    def __str__(self) -> str:
        if self.position is not None:
            return f"lock {self.actuator} position {self.position!r}"
        if self.force is not None:
            return f"lock {self.actuator} force {self.force!r}"
        return f"unlock {self.actuator}"


OperatorOrder = OperatorCommand | LockOrder
