"""Robots of several parts, some of which are in the coordinates of state bases of their own."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from tauten.model import Robot, State
from tauten.model.effectors import Effectors
from tauten.model.numerics import Array
from tauten.model.parts import Part, PartsBody, PartsPoints, join_parts, joined_state
from tauten.reduction.state.basis import StateBasis, reduced_robot

Lift = Callable[[State], State]


@dataclass(frozen=True, slots=True, eq=False)
class ReducedParts(PartsBody):
    """A body of parts that replaces one of full parts.

    Attributes, beside those of every body of parts:
        full: the robot whose body it replaces.
        lift: of each part, from its state to that of the full part.
    """

    full: Robot[PartsBody]
    lift: tuple[Lift, ...]

    def lifted(self, state: State) -> State:
        """The state of the full robot."""
        pairs = zip(self.lift, self.states(state), strict=True)
        return joined_state([lift(own) for lift, own in pairs])

    def loaded(
        self, gravity: Array, effector_force: Array, effectors: Effectors[PartsPoints]
    ) -> ReducedParts:
        """The body under other loads, see `Body`."""
        loaded = super(ReducedParts, self).loaded(gravity, effector_force, effectors)
        return dataclasses.replace(
            self,
            gravity=gravity,
            parts=loaded.parts,
            full=self.full.loaded(gravity, effector_force),
        )


def reduced_parts(robot: Robot[Any], bases: Sequence[StateBasis | None]) -> Robot[ReducedParts]:
    """A robot of full parts with those in reduced coordinates that have a state basis.

    Raises:
        StateBasisError: a basis was made for another robot than that of its part.
    """
    parts: list[Part] = []
    lift: list[Lift] = []
    for part, basis in zip(robot.body.parts, bases, strict=True):
        if basis is None:
            parts.append(part)
            lift.append(unchanged)
            continue
        reduced = reduced_robot(part.robot, basis)
        parts.append(part.made_of(reduced))
        lift.append(reduced.body.lifted)
    joined = join_parts(robot.body.assembly, parts)
    given = [field.name for field in dataclasses.fields(PartsBody) if field.init]
    fields = {name: getattr(joined.body, name) for name in given}
    body = ReducedParts(**fields, full=robot, lift=tuple(lift))
    return joined.with_body(body, joined.effectors, joined.contacts, joined.vertices)


def unchanged(state: State) -> State:
    """The state of a part that is a full one."""
    return state
