"""The side of obstacles and other bodies on which a robot was before the long steps of a settling."""

from __future__ import annotations

from tauten.model.robot import Robot
from tauten.model.state import State
from tauten.model.step import CondensedStep


class WayIn:
    """What a long step takes into an obstacle or another body is led out where it came in.

    The way in starts at the last state in which nothing was deeper in others than the tolerance of contact
    (`tauten.model.contact.sides`): farther inside, the nearest point of a plate may be on its other side.
    """

    def __init__(self, robot: Robot, state: State) -> None:
        """At the first state."""
        self._robot, self._outside = robot, state

    def robot_at(self, state: State) -> Robot:
        """The robot with contacts at a state on the sides where it came from."""
        return self._robot.stepping(self._outside, 0.0, state)

    def observe(self, step: CondensedStep) -> None:
        """Start the way at the start of a step, where nothing is inside there."""
        if step.rows.contacts.found.gap.min(initial=0.0) >= -self._robot.tolerance:
            self._outside = step.state
