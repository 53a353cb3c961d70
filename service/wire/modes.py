"""Modes of the node, causes for not following, and commands of an operator, with their names on the wire."""

from __future__ import annotations

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


class OperatorCommand(StrEnum):
    """Commands of an operator."""

    ENABLE = "enable"  # follow targets again
    HOLD = "hold"  # do not move the winches until enabled
    STOP = "stop"  # release the cables
    RESET = "reset"  # from a finished stop back to idle
