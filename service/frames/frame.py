"""What the viewer shows: the fixed looks of a robot, and one frame of its motion."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model import Floats, Geometry
from tauten.model.numerics import Array, Ints
from tauten.service.frames.effectors import distance_between, positions_of, targets_of
from tauten.service.wire import Cause, Mode, RobotDescription


@dataclass(frozen=True, slots=True)
class RobotLook:
    """What of a robot does not change.

    Attributes:
        robot: its description.
        vertices: (P, 3) of its skin at rest [m].
        ghost: (t, 3) triangles of the model beside the robot, for a simulation; None: there is none.
    """

    robot: RobotDescription
    vertices: Floats
    ghost: Ints | None = None

    def positions(self, values: Array) -> Array:
        """Positions (p, 3) [m] among goal values (n_v,); NaN for effectors without one."""
        return positions_of(self.robot.effectors, values)

    def targets(self, frame: ViewFrame) -> Array:
        """Where the targets of a frame are shown: (p, 3) [m]; NaN for effectors without a position."""
        return targets_of(self.robot.effectors, frame.goal, frame.values)

    def error(self, frame: ViewFrame) -> float:
        """Largest distance of an effector from its target [m]; NaN without a target."""
        return distance_between(self.robot.effectors, frame.goal, frame.values)


@dataclass(frozen=True, slots=True, eq=False)
class ViewFrame:
    """One moment of a robot.

    Attributes:
        time: since the start [s].
        mode: of the node.
        cause: why it does not follow.
        status: of the decision, "" where nothing was decided.
        geometry: where the robot is.
        position: (n_a,) positions of the actuators [SI].
        effort: (n_a,) their efforts [SI].
        goal: (n_v,) goal values that are followed, NaN where none are.
        values: (n_v,) goal values where the effectors are.
        step: time of the control step [s].
        ghost: (P, 3) vertices of the model beside the robot [m]; None: there is none.
    """

    time: float
    mode: Mode
    cause: Cause
    status: str
    geometry: Geometry
    position: Array
    effort: Array
    goal: Array
    values: Array
    step: float
    ghost: Floats | None = None

    @property
    def nbytes(self) -> int:
        """Memory of its large arrays [bytes]."""
        geometry = self.geometry
        contacts = geometry.contacts
        arrays = (geometry.vertices, geometry.segments, contacts.points, contacts.forces)
        ghost = 0 if self.ghost is None else self.ghost.nbytes
        return ghost + sum(array.nbytes for array in arrays)
