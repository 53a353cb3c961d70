"""The laws of actuators: what their positions and efforts obey where one of the two is given.

A cable obeys 0 ≤ δ − pull ⟂ λ ≥ 0 where its pull is given: it may be slack and never pushes. All others are
bilateral, δ = pull with λ of either sign, and so is a cable whose tension may be negative, a rod. Between a
motor and what it moves there may be a spring. Which rows of a step obey which law is in
`tauten.model.step.sorted_rows`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Bools, Ints, joined
from tauten.model.signals.command import Command
from tauten.model.signals.limits import Limits


@dataclass(frozen=True, slots=True)
class Springs:
    """Springs in series between motors and what they move: δ_motor = δ + flexibility λ + shift.

    Attributes:
        flexibility: (n_a,) inverse stiffness, zero without a spring [m/N].
        shift: (n_a,) position of the motor where δ and λ are zero, negative with pretension [m].
    """

    flexibility: Array
    shift: Array

    def effort(self, position: Array, delta: Array) -> Array:
        """Efforts (n_a,) of the springs between motors at `position` and what they move, at `delta`."""
        stretch = position - delta - self.shift
        return np.divide(
            stretch, self.flexibility, out=np.zeros_like(stretch), where=self.flexibility > 0.0
        )

    @classmethod
    def none(cls, count: int) -> Springs:
        """No springs at `count` actuators."""
        return cls(np.zeros(count), np.zeros(count))


@dataclass(frozen=True, slots=True)
class Laws:
    """The laws of all actuators of a robot.

    Attributes:
        bilateral: (n_a,) whether δ = pull holds where the pull is given, with an effort of either sign.
        held_by_force: (n_a,) whether a hold keeps λ rather than δ.
        springs: between motors and what they move; None: there are none.
    """

    bilateral: Bools
    held_by_force: Bools
    springs: Springs | None = None

    def at(self, chosen: Ints) -> Laws:
        """Laws of some actuators, by their numbers (c,), without springs."""
        return Laws(self.bilateral[chosen], self.held_by_force[chosen])

    @classmethod
    def joined(cls, parts: Sequence[Laws]) -> Laws:
        """Laws of the actuators of several parts, one part after the other."""
        springs = [part.springs or Springs.none(len(part.bilateral)) for part in parts]
        return cls(
            np.concatenate([part.bilateral for part in parts]),
            np.concatenate([part.held_by_force for part in parts]),
            joined(springs) if any(part.springs is not None for part in parts) else None,
        )

    def held(self, position: Array, effort: Array) -> Command:
        """What a hold keeps of positions and efforts (n_a,)."""
        return Command.either(self.held_by_force, position, effort)

    def motors(self, delta: Array, lam: Array) -> Array:
        """Positions of the motors (n_a,) of positions delta and efforts lam of what they move."""
        if self.springs is None:
            return delta.copy()
        position: Array = delta + self.springs.flexibility * lam + self.springs.shift
        return position

    def slack(self, effort: Array, limits: Limits, rounding: float) -> Bools:
        """Which cables have their least tension: (n_a,).

        Args:
            effort: (n_a,) [N, Pa].
            limits: of the actuators.
            rounding: what is rounding of an effort, relative to the largest.
        """
        least = limits.effort_min + rounding * limits.largest_effort
        found: Bools = ~self.bilateral & (effort <= least)
        return found

    def beyond(self, effort: Array, limits: Limits) -> Array:
        """How far efforts (n_a,) exceed their limits, relative to the largest: (n_a,), negative within.

        The least tension of a cable does not count: one that is held may be slack.
        """
        below = limits.effort_min - effort
        below[~self.bilateral] = -np.inf
        excess: Array = np.maximum(effort - limits.effort_max, below) / limits.largest_effort
        return excess

    def penalty(self, command: Command, delta: Array, weights: Array) -> float:
        """Exact penalty of actuators at positions delta (n_a,) that are not those commanded [J].

        The work of given efforts, the energy of springs, and the weighted distance from given positions; a
        cable whose path is shorter than its winch allows is at none.

        Args:
            command: position or effort of each.
            delta: (n_a,) positions.
            weights: (n_a,) of the distances, larger than the efforts at the positions commanded [N].
        """
        given = command.by_force
        value = -float(command.effort[given] @ delta[given])
        short, stiff = np.where(given, 0.0, command.position - delta), ~given
        if self.springs is not None:
            springs = self.springs
            effort = springs.effort(np.where(given, 0.0, command.position), delta)
            effort = np.where(self.bilateral, effort, np.maximum(effort, 0.0))
            soft = stiff & (springs.flexibility > 0.0)
            value += 0.5 * float(springs.flexibility[soft] @ effort[soft] ** 2)
            stiff &= ~soft
        short = np.where(self.bilateral, np.abs(short), np.maximum(short, 0.0))
        return value + float(weights[stiff] @ short[stiff])
