"""A part of a robot: a robot in a place, with unknowns, forces and bases of its own."""

from __future__ import annotations

from dataclasses import dataclass, replace

from tauten.model.parts.placement import Placement
from tauten.model.robot import Robot


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A part: what is coupled by coordinates or by elasticity.

    Attributes:
        name: of the part, used once.
        robot: the part in its own frame, as its file describes it.
        placement: where that frame stands in the frame of all parts.
    """

    name: str
    robot: Robot
    placement: Placement

    def named(self, name: str) -> str:
        """What an actuator or effector of the part is called among those of all parts."""
        return f"{self.name}_{name}"

    def made_of(self, robot: Robot) -> Part:
        """The part with another robot in the same place: reduced, under other loads, another workspace."""
        return replace(self, robot=robot)
