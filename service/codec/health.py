"""Health: counters by reason and times in fixed memory, as a diagnostic_msgs/DiagnosticArray."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from enum import IntEnum
from math import isnan
from typing import TYPE_CHECKING

import numpy as np

from tauten.service.codec.messages import (
    HEALTH,
    from_cdr,
    header,
    new,
    to_cdr,
)
from tauten.service.codec.rejection import Rejection, RejectionReason

if TYPE_CHECKING:
    from tauten.model.numerics import Array

# Numbers of a certificate of contacts with friction, and what they are called in health.
CERTIFIED = {
    "error": "error [m]",
    "cone": "beyond the cone [N]",
    "angle": "slip to friction [rad]",
    "work": "work of friction [J]",
    "least_margin": "least distance to slip [N]",
}


_KEPT = 1024  # values of a quantity


class Level(IntEnum):
    """Levels of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


class Window:
    """The last values of a measured quantity, in fixed memory."""

    def __init__(self) -> None:
        self._values = np.full(_KEPT, np.nan)
        self._count = 0
        self.largest = 0.0

    def add(self, value: float) -> None:
        """Add a value; NaN is left out."""
        if isnan(value):
            return
        self._values[self._count % len(self._values)] = value
        self._count += 1
        self.largest = max(self.largest, value)

    def values(self) -> Array:
        """The values kept, in no particular order."""
        return self._values[: min(self._count, len(self._values))]

    def entries(self, name: str, factor: float) -> dict[str, str]:
        """p50 and p99 of the values kept and the largest of all, each times a factor, as text.

        The keys are the name of the quantity with a suffix.
        """
        values = np.sort(self.values())  # twenty times as fast as np.percentile
        if len(values) == 0:
            return {}
        p50, p99 = (values[round(part * (len(values) - 1))] for part in (0.5, 0.99))
        named = {"p50": p50, "p99": p99, "max": self.largest}
        return {f"{name}_{key}": f"{factor * value:.4g}" for key, value in named.items()}


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One diagnostic_msgs/DiagnosticStatus.

    Attributes:
        name: its subject, such as "targets".
        level: severity.
        message: one sentence.
        values: named numbers and texts.
    """

    name: str
    level: Level
    message: str
    values: dict[str, str]


@dataclass(slots=True)
class MessageCounts:
    """Counts of messages that arrived on a key: accepted, and refused by reason."""

    accepted: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    last_rejection: str = ""

    def refuse(self, rejection: Rejection) -> None:
        """Count a refusal."""
        self.refused[rejection.reason.value] += 1
        self.last_rejection = rejection.detail

    def diagnostic(self, name: str) -> Diagnostic:
        """As health."""
        bad = sum(self.refused.values())
        message = f"{bad} refused, last: {self.last_rejection}" if bad else "all accepted"
        values = {"accepted": str(self.accepted), "refused": str(bad)}
        values |= {f"refused_{reason}": str(count) for reason, count in self.refused.items()}
        if bad:
            values["last_refusal"] = self.last_rejection
        return Diagnostic(name, Level.WARN if bad else Level.OK, message, values)


def encode_health(stamp: int, robot: str, diagnostics: list[Diagnostic]) -> bytes:
    """Diagnostics of a robot in CDR, with a stamp [ns since the epoch]."""
    status = [
        new(
            "diagnostic_msgs/msg/DiagnosticStatus",
            level=int(item.level),
            name=f"tauten/{robot}: {item.name}",
            message=item.message,
            hardware_id=robot,
            values=[
                new("diagnostic_msgs/msg/KeyValue", key=key, value=value)
                for key, value in item.values.items()
            ],
        )
        for item in diagnostics
    ]
    return to_cdr(HEALTH, new(HEALTH, header=header(stamp, ""), status=status))


def decode_health(payload: bytes) -> dict[str, Diagnostic] | Rejection:
    """Diagnostics by name, from CDR."""
    message = from_cdr(HEALTH, payload)
    if isinstance(message, Rejection):
        return message
    levels = [status.level for status in message.status]
    unknown = sorted(set(levels) - set(Level))
    if unknown:
        detail = f"found level {unknown[0]}, allowed are {', '.join(map(str, map(int, Level)))}"
        return Rejection(RejectionReason.MALFORMED, detail)
    found = [
        Diagnostic(
            name=status.name.partition(": ")[2],
            level=Level(status.level),
            message=status.message,
            values={entry.key: entry.value for entry in status.values},
        )
        for status in message.status
    ]
    return {item.name: item for item in found}
