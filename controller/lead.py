"""How far a decision leads a target that moves: by the motion that its plan leaves for after the tick.

A plan ends at the horizon. What follows the actuators slowly, as the tip of a body under pressure follows its
volume, is at the target only then, so that a target that moves would be followed late, by up to its way in a
horizon. Let e be the motion of the effectors from the end of the tick to the end of the plan, in the decision
before. The plan for the target plus e has the effectors at the target when the tick ends.

Only the motion of the target is led: e counts in each row as far as the target has moved within the last
horizon, evenly, which is twice the smaller one of its ways in both halves of that time. So a target that
stays or jumps is not led, and the robot comes to rest as it would without. And e is averaged over the ticks
of a horizon: a decision that answered to the e of the one before alone would repeat its changes of sign,
which grow where actuators share their load in more than one way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model import EffectorLayout
from tauten.model.numerics import Array


@dataclass(frozen=True, slots=True)
class Lead:
    """What a decision takes over from those before.

    Attributes:
        remaining: (n_e,) motion of the effector rows e from the end of the tick to the end of the plan,
            averaged [m].
        goals: (n_v,) goal values of the last ticks, oldest first.
    """

    remaining: Array
    goals: tuple[Array, ...]


def no_lead() -> Lead:
    """The start, and after ticks without a target."""
    return Lead(np.zeros(0), ())


def leading(lead: Lead, layout: EffectorLayout, goal: Array, ticks: int) -> Array:
    """What is added to the targets of the rows: (n_e,) [m].

    Args:
        lead: of the decisions before.
        layout: of the effectors.
        goal: (n_v,) present goal values.
        ticks: of the horizon.
    """
    half, goals = ticks // 2, lead.goals
    if half == 0 or len(goals) < 2 * half:
        return np.zeros(layout.n_rows)
    later = layout.difference(goal, goals[-half])
    earlier = layout.difference(goals[-half], goals[-2 * half])
    even = np.where(later * earlier > 0.0, np.minimum(np.abs(later), np.abs(earlier)), 0.0)
    bound = 2.0 * np.copysign(even, later)  # (n_e,)
    led: Array = lead.remaining.clip(np.minimum(bound, 0.0), np.maximum(bound, 0.0))
    return led


def with_tick(lead: Lead, goal: Array, remaining: Array, ticks: int) -> Lead:
    """What the next decision takes over.

    Args:
        lead: of the decisions before.
        goal: (n_v,) goal values of this one.
        remaining: (n_e,) motion that its plan leaves for after the tick [m].
        ticks: of the horizon.
    """
    average = lead.remaining if len(lead.remaining) else np.zeros_like(remaining)  # (n_e,)
    average = average + (remaining - average) / max(ticks, 1)
    return Lead(average, (*lead.goals, goal)[-2 * max(ticks // 2, 1) :])
