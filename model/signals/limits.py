"""Limits of the actuators: effort λ, position δ, rate of δ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from functools import cached_property

import numpy as np

from tauten.model.numerics import Array, Ints
from tauten.model.schema import CouplingSettings, Range, RobotConfig, RobotFileError


@dataclass(frozen=True)
class Limits:
    """Limits of the actuators, each (n_a,), in the units of their kinds and the order of `Range`.

    Attributes:
        effort_min: smallest effort [N, Pa]; of cables that are no rods at least 0.
        effort_max: largest effort [N, Pa].
        position_min: smallest position [m, m³].
        position_max: largest position [m, m³].
        rate: largest rate of the position [m/s, m³/s].
    """

    effort_min: Array
    effort_max: Array
    position_min: Array
    position_max: Array
    rate: Array

    @cached_property
    def largest_effort(self) -> Array:
        """Larger magnitude of both limits of the effort: (n_a,)."""
        return np.maximum(np.abs(self.effort_min), np.abs(self.effort_max))

    @cached_property
    def farthest_position(self) -> Array:
        """Limit of the position with the larger magnitude, with its sign: (n_a,).

        Of what only pulls it is the largest one: letting out a cable moves nothing.
        """
        pulls = (self.effort_min >= 0.0) & (self.position_max > 0.0)
        farthest: Array = np.where(
            pulls | (self.position_max >= -self.position_min), self.position_max, self.position_min
        )
        return farthest

    @classmethod
    def of(cls, ranges: Sequence[Range]) -> Limits:
        """Limits of actuators, each given as a range."""
        return cls(*np.array([astuple(one) for one in ranges]).reshape(-1, 5).T.copy())

    def range_of(self, actuator: int) -> Range:
        """The limits of one actuator by its number."""
        return Range(*(float(getattr(self, field.name)[actuator]) for field in fields(Limits)))

    def at(self, chosen: Ints) -> Limits:
        """The limits of some actuators, by their numbers (c,)."""
        return Limits(*(getattr(self, field.name)[chosen] for field in fields(Limits)))


def limits_of(config: RobotConfig, source: str = "robot file") -> Limits:
    """Limits of the actuators of a robot file.

    Raises:
        RobotFileError: the efforts of a coupling leave no effort that all of its members allow.
    """
    single = {item.name: item.limits for item in config.single_actuators}
    ranges = []
    for item in config.actuators:
        if isinstance(item, CouplingSettings) and item.kind == "differential":
            try:
                ranges.append(coupled_range(item, [single[name] for name in item.members]))
            except ValueError as error:
                raise RobotFileError(f"{source}: {error}") from error
        else:
            ranges.append(item.limits)
    return Limits.of(ranges)


def coupled_range(item: CouplingSettings, members: Sequence[Range]) -> Range:
    """Limits of a motor of several actuators: its own, and the efforts that every member allows.

    Raises:
        ValueError: they leave no effort.
    """
    own, least, most = item.limits, item.limits.least_effort, item.limits.most_effort
    for gain, offset, member in zip(item.gains, item.offsets, members, strict=True):
        ends = sorted([(member.least_effort - offset) / gain, (member.most_effort - offset) / gain])
        least, most = max(least, ends[0]), min(most, ends[1])
    change = "change pretensions, gains or the members' limits"
    if least == most == 0.0:
        raise ValueError(
            f"couplings.{item.name}: the limits of its members allow no effort of its motor but 0: {change}"
        )
    if not least <= 0.0 <= most:
        raise ValueError(
            f"couplings.{item.name}: the limits of its members allow efforts of the motor from {least:g} to "
            f"{most:g}; zero, the value at rest, must be between them: {change}"
        )
    return Range(least, most, own.least_position, own.most_position, own.rate)
