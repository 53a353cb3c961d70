"""What the viewer shows: the fixed looks of a robot, and one frame of its motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauten.model import Robot, State
from tauten.model.numerics import Array, Ints
from tauten.service.wire import Cause, Mode

Floats: TypeAlias = NDArray[np.float32]

_PUSHING = 1e-3  # of the largest force; smaller ones are not drawn


@dataclass(frozen=True, slots=True)
class ActuatorLook:
    """How an actuator is shown.

    Attributes:
        name: of the actuator.
        travel_unit: unit of what it has travelled, δ_a, as shown.
        force_unit: unit of its force, λ_a, as shown.
        travel_scale: from SI to `travel_unit`.
        force_scale: from SI to `force_unit`.
        travel: its limits [SI].
        force: its limits [SI].
    """

    name: str
    travel_unit: str
    force_unit: str
    travel_scale: float
    force_scale: float
    travel: tuple[float, float]
    force: tuple[float, float]


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
        cable_owners: (s,) the actuator of every cable segment.
        actuators: in the order of λ_a.
        effectors: names.
        rest: (p, 3) of the effectors [m].
    """

    name: str
    frame: str
    rate: float
    size: float
    vertices: Floats
    triangles: Ints
    cable_owners: Ints
    actuators: tuple[ActuatorLook, ...]
    effectors: tuple[str, ...]
    rest: Array


@dataclass(frozen=True, slots=True)
class Contacts:
    """Contacts that push.

    Attributes:
        points: (c, 3) [m].
        forces: (c, 3) on the body at these points [N].
    """

    points: Floats
    forces: Floats


NO_CONTACTS = Contacts(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.float32))


@dataclass(frozen=True, slots=True)
class Geometry:
    """Where a robot is.

    Attributes:
        vertices: (P, 3) of its skin [m].
        cables: (s, 2, 3) ends of the cable segments [m].
        contacts: that push.
    """

    vertices: Floats
    cables: Floats
    contacts: Contacts


@dataclass(frozen=True, slots=True)
class ViewFrame:
    """One moment of a robot.

    Attributes:
        time: since the start [s].
        mode: of the node.
        cause: why it does not follow.
        status: of the decision, "" where nothing was decided.
        geometry: where the robot is.
        pull: (n_a,) what the actuators have travelled [SI].
        tension: (n_a,) their forces [SI].
        target: (p, 3) that is followed [m], NaN where none is.
        effector: (p, 3) [m].
        step: time of the control step [s].
    """

    time: float
    mode: Mode
    cause: Cause
    status: str
    geometry: Geometry
    pull: Array
    tension: Array
    target: Array
    effector: Array
    step: float

    @property
    def error(self) -> float:
        """Largest distance of an effector from its target [m]; NaN without a target."""
        return float(np.linalg.norm(self.target - self.effector, axis=1).max())

    @property
    def nbytes(self) -> int:
        """Memory of its large arrays [bytes]."""
        geometry = self.geometry
        contacts = geometry.contacts
        arrays = (geometry.vertices, geometry.cables, contacts.points, contacts.forces)
        return sum(array.nbytes for array in arrays)


@dataclass(frozen=True, slots=True)
class Skin:
    """The vertices of a robot's surface among its points.

    Attributes:
        used: (P,) which of the robot's points they are.
        triangles: (t, 3) of the vertices.
    """

    used: Ints
    triangles: Ints

    def geometry(self, robot: Robot, state: State, lam: Array | None) -> Geometry:
        """Where a robot is.

        Args:
            robot: whose skin this is.
            state: of the robot.
            lam: (n_c,) contact forces [N]; None: they are left out, which is faster.
        """
        return Geometry(
            robot.points(state)[self.used].astype(np.float32),
            robot.cable_segments(state).astype(np.float32),
            NO_CONTACTS if lam is None else pushing_contacts(robot, state, lam),
        )


def skin_of(robot: Robot) -> Skin:
    """The skin of a robot."""
    used, inverse = np.unique(robot.triangles, return_inverse=True)
    return Skin(used, inverse.reshape(-1, 3))


def pushing_contacts(robot: Robot, state: State, lam: Array) -> Contacts:
    """Contacts that push in a state.

    Args:
        robot: the robot.
        state: of the robot.
        lam: (n_c,) contact forces [N].
    """
    largest = float(lam.max(initial=0.0))
    if largest <= 0.0:
        return NO_CONTACTS
    forces = lam[:, None] * robot.contact_normals(state)  # (n_c, 3), NaN out of range
    shown = np.flatnonzero((lam > _PUSHING * largest) & np.isfinite(forces).all(axis=1))
    points = robot.candidates(state)[shown]
    return Contacts(points.astype(np.float32), forces[shown].astype(np.float32))


def look_of(robot: Robot, skin: Skin) -> RobotLook:
    """The looks of a robot.

    Args:
        robot: the robot.
        skin: its skin.
    """
    limits, rest = robot.limits, robot.rest()
    actuators = tuple(
        cable_look(
            name,
            (float(limits.pull_min[i]), float(limits.pull_max[i])),
            (float(limits.tension_min[i]), float(limits.tension_max[i])),
        )
        for i, name in enumerate(robot.cable_names)
    )
    return RobotLook(
        name=robot.name,
        frame=robot.frame,
        rate=robot.integration.rate,
        size=robot.size,
        vertices=robot.points(rest)[skin.used].astype(np.float32),
        triangles=skin.triangles,
        cable_owners=robot.cable_owners,
        actuators=actuators,
        effectors=robot.effector_names,
        rest=robot.effector(rest),
    )


def cable_look(name: str, pull: tuple[float, float], tension: tuple[float, float]) -> ActuatorLook:
    """How a cable is shown.

    Args:
        name: of the cable.
        pull: limits of its pulled length [m].
        tension: its limits [N].
    """
    return ActuatorLook(name, "mm", "N", 1e3, 1.0, pull, tension)
