"""What the viewer shows: the fixed looks of a robot, and one frame of its motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model import ActuatorKind, Floats, Geometry, Quantity, Robot, SkinMesh, State
from tauten.model.numerics import Array, Ints
from tauten.service.frames.effectors import (
    EffectorLook,
    distance_between,
    effector_looks,
    positions_of,
    targets_of,
)
from tauten.service.wire import Cause, Mode


@dataclass(frozen=True, slots=True)
class ActuatorLook:
    """How an actuator is shown.

    Attributes:
        name: of the actuator.
        kind: cable, chamber or another, with its units.
        position_range: limits of its position δ_a [SI].
        effort_range: limits of its effort λ_a [SI].
        flexibility: inverse stiffness of the spring between motor and cable [m/N]; 0 without one.
    """

    name: str
    kind: ActuatorKind
    position_range: tuple[float, float]
    effort_range: tuple[float, float]
    flexibility: float = 0.0

    @property
    def position(self) -> Quantity:
        """What δ_a is."""
        return self.kind.position

    @property
    def effort(self) -> Quantity:
        """What λ_a is."""
        return self.kind.effort


@dataclass(frozen=True, slots=True)
class RobotLook:
    """What of a robot does not change.

    Attributes:
        name: of the robot.
        frame: frame id of its positions.
        rate: control rate [Hz].
        size: diagonal of its bounding box at rest [m].
        vertices: (P, 3) of its skin at rest [m].
        triangles: (t, 3) of its skin.
        segment_owners: (s,) the actuator of every segment, see `Robot.actuator_segments`.
        chamber_owners: (t,) the actuator whose chamber a triangle encloses; −1: none.
        actuators: in the order of λ_a.
        effectors: in the order of their goal values.
        gravity: (3,) acceleration of gravity [m/s²].
        ghost: (t, 3) triangles of the model beside the robot, for a simulation; None: there is none.
    """

    name: str
    frame: str
    rate: float
    size: float
    vertices: Floats
    triangles: Ints
    segment_owners: Ints
    chamber_owners: Ints
    actuators: tuple[ActuatorLook, ...]
    effectors: tuple[EffectorLook, ...]
    gravity: tuple[float, float, float]
    ghost: Ints | None = None

    @property
    def rest(self) -> Array:
        """Goal values (n_v,) of the effectors at rest."""
        return np.concatenate([np.array(one.rest) for one in self.effectors])

    def positions(self, values: Array) -> Array:
        """Positions (p, 3) [m] among goal values (n_v,); NaN for effectors without one."""
        return positions_of(self.effectors, values)

    def targets(self, frame: ViewFrame) -> Array:
        """Where the targets of a frame are shown: (p, 3) [m]; NaN for effectors without a position."""
        return targets_of(self.effectors, frame.goal, frame.values)

    def error(self, frame: ViewFrame) -> float:
        """Largest distance of an effector from its target [m]; NaN without a target."""
        return distance_between(self.effectors, frame.goal, frame.values)


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


def look_of(robot: Robot, skin: SkinMesh, rest: State) -> RobotLook:
    """The looks of a robot.

    Args:
        robot: the robot.
        skin: its skin.
        rest: where it starts.
    """
    limits, layout = robot.limits, robot.effector_layout
    springs = robot.actuators.laws.springs
    at_rest = robot.effector_values(rest)
    values = [tuple(at_rest[layout.values_of(i)].tolist()) for i in range(len(layout))]
    weights = [tuple(layout.weights[layout.rows_of(i)].tolist()) for i in range(len(layout))]
    x, y, z = robot.gravity
    actuators = tuple(
        ActuatorLook(
            name,
            kind,
            (float(limits.position_min[i]), float(limits.position_max[i])),
            (float(limits.effort_min[i]), float(limits.effort_max[i])),
            float(springs.flexibility[i]) if springs is not None else 0.0,
        )
        for i, (name, kind) in enumerate(
            zip(robot.actuators.names, robot.actuators.kinds, strict=True)
        )
    )
    return RobotLook(
        name=robot.name,
        frame=robot.frame,
        rate=robot.integration.rate,
        size=robot.size,
        vertices=robot.points(rest)[skin.used].astype(np.float32),
        triangles=skin.triangles,
        segment_owners=robot.segment_owners,
        chamber_owners=robot.chamber_owners,
        actuators=actuators,
        effectors=effector_looks(robot.effector_names, layout.kinds, values, weights),
        gravity=(float(x), float(y), float(z)),
    )
