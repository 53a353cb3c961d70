"""Health: counters by reason and times in fixed memory, as a diagnostic_msgs/DiagnosticArray."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from enum import IntEnum
from math import isnan

import numpy as np

from tauten.model.numerics import Array
from tauten.service.wire.messages import HEALTH, Rejection, from_cdr, header, new, to_cdr


class Level(IntEnum):
    """Levels of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


class Window:
    """The last values of something measured, in fixed memory."""

    def __init__(self, size: int = 1024) -> None:
        """Remember `size` values."""
        self._values = np.full(size, np.nan)  # (size,)
        self._count = 0
        self.largest = 0.0

    def add(self, value: float) -> None:
        """Remember a value; NaN is left out."""
        if isnan(value):
            return
        self._values[self._count % len(self._values)] = value
        self._count += 1
        self.largest = max(self.largest, value)

    def values(self) -> Array:
        """The values remembered, in no particular order."""
        return self._values[: min(self._count, len(self._values))]

    def entries(self, name: str, factor: float) -> dict[str, str]:
        """p50 and p99 of the values remembered and the largest ever, scaled, as text."""
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
        name: what it is about, such as "targets".
        level: how well it is.
        message: one sentence.
        values: named numbers and texts.
    """

    name: str
    level: Level
    message: str
    values: dict[str, str]


@dataclass(slots=True)
class MessageCounts:
    """Counts of messages that arrived on a key, by what became of them."""

    accepted: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    last_fault: str = ""

    def refuse(self, fault: Rejection) -> None:
        """Count a refusal."""
        self.refused[fault.reason.value] += 1
        self.last_fault = fault.detail

    def diagnostic(self, name: str) -> Diagnostic:
        """As health."""
        bad = sum(self.refused.values())
        message = f"{bad} refused, last: {self.last_fault}" if bad else "all accepted"
        values = {"accepted": str(self.accepted), "refused": str(bad)}
        values |= {f"refused_{reason}": str(count) for reason, count in self.refused.items()}
        return Diagnostic(name, Level.WARN if bad else Level.OK, message, values)


def encode_health(stamp: int, robot: str, diagnostics: list[Diagnostic]) -> bytes:
    """Diagnostics of a robot in CDR."""
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
