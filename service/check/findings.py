"""One line of `tauten check`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Level = Literal["fine", "doubtful", "wrong"]
LEVELS: tuple[Level, ...] = ("fine", "doubtful", "wrong")


@dataclass(frozen=True, slots=True)
class Finding:
    """What was looked at and what it means.

    Attributes:
        subject: what was looked at.
        level: whether it is fine, doubtful or wrong.
        found: measured values with their units.
        advice: what to change; "" where nothing is.
    """

    subject: str
    level: Level
    found: str
    advice: str = ""


def worst(findings: tuple[Finding, ...]) -> Level:
    """The worst level of all."""
    return max((item.level for item in findings), key=LEVELS.index, default="fine")


def graded(value: float, doubtful: float, wrong: float) -> Level:
    """The level of a value that should be small.

    Args:
        value: the value.
        doubtful: where it starts to be doubtful.
        wrong: where it starts to be wrong.
    """
    if not value < wrong:
        return "wrong"
    return "fine" if value < doubtful else "doubtful"
