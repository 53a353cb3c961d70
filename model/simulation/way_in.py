"""The side of obstacles and other bodies on which a robot was before the long steps of a settling."""

from __future__ import annotations

from tauten.model.robot import Robot
from tauten.model.state import State
from tauten.model.step import CondensedStep, ContactSpace, Forces, condense_step
from tauten.model.system import Integration


class WayIn:
    """Steps in which what a long one takes into an obstacle or another body is led out where it came in.

    The way in starts at the last state in which nothing was deeper in others than the tolerance of contact
    (`tauten.model.contact.sides`): farther inside, the nearest point of a plate may be on its other side.
    """

    def __init__(self, robot: Robot, state: State) -> None:
        """At the first state."""
        self._robot, self._outside = robot, state

    def condensed(
        self,
        space: ContactSpace,
        state: State,
        forces: Forces,
        contacts: bool,
        scheme: Integration,
    ) -> CondensedStep:
        """The step from a state, with contacts on the sides where it came from; see `condense_step`."""
        robot = self._robot.stepping(self._outside, 0.0, state) if contacts else self._robot
        step = condense_step(robot, space, state, forces, contacts, False, scheme)
        if step.rows.contacts.found.gap.min(initial=0.0) >= -self._robot.tolerance:
            self._outside = state
        return step
