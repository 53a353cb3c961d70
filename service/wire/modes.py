"""Modes of the node, why it does not follow, and the commands of an operator, as the wire names them."""

from __future__ import annotations

from enum import StrEnum


class Mode(StrEnum):
    """What the node is doing."""

    IDLE = "idle"  # at rest, nothing followed yet
    RUN = "run"  # following targets
    HOLD = "hold"  # winches stand still where they are
    STOP = "stop"  # cables are let go, then slack until a reset


class Cause(StrEnum):
    """Why the node does not follow; the value is what health and ticks say."""

    NONE = ""
    NO_TARGET = "no target"
    OPERATOR = "operator"
    LATE = "deadlines missed"
    UNMEASURED = "no measurement"
    UNUSABLE = "decision not usable"
    SHUTDOWN = "shutting down"


class OperatorCommand(StrEnum):
    """What an operator may ask for."""

    ENABLE = "enable"  # follow targets again
    HOLD = "hold"  # stand still until enabled
    STOP = "stop"  # let the cables go
    RESET = "reset"  # from a finished stop back to idle
