"""Where frames come from: a simulation, a served robot or a log, behind one interface."""

from __future__ import annotations

from typing import Protocol

from tauten.model.numerics import Array
from tauten.service.frames.frame import RobotLook, ViewFrame
from tauten.service.wire import OperatorOrder


class FrameSource(Protocol):
    """A robot that moves."""

    @property
    def look(self) -> RobotLook:
        """What of it does not change."""

    @property
    def pausable(self) -> bool:
        """Whether the robot itself stops while it is not advanced: a simulation does."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about its state, for the panel."""

    def advance(self, goal: Array | None, drawn: bool) -> ViewFrame | None:
        """One period of the robot.

        Args:
            goal: (n_v,) goal values to follow; None: nothing to follow.
            drawn: whether a frame is wanted.

        Returns:
            The frame; None where there is none, or none is wanted.
        """

    @property
    def locked(self) -> frozenset[str]:
        """Names of the actuators that are locked."""

    def command(self, command: OperatorOrder) -> None:
        """Send an operator's order."""
