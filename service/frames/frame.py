"""What the viewer shows: the fixed looks of a robot, and one frame of its motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from tauten.model import Floats, Geometry
from tauten.model.contact import ObstaclePose
from tauten.model.numerics import Array, Ints
from tauten.service.wire import Cause, DescribedEffector, Mode, RobotDescription, places_of


def positions_of(effectors: tuple[DescribedEffector, ...], values: Array) -> Array:
    """Positions (..., p, 3) [m] among goal values (..., n_v); NaN for effectors without one."""
    found = np.full((*values.shape[:-1], len(effectors), 3), np.nan)
    for i, (effector, place) in enumerate(zip(effectors, places_of(effectors), strict=True)):
        if effector.has_position:
            found[..., i, :] = values[..., place][..., :3]
    return found


def targets_of(effectors: tuple[DescribedEffector, ...], goal: Array, values: Array) -> Array:
    """Where targets are shown: (..., p, 3) [m]; coordinates that are left free are those of the effector.

    Args:
        effectors: of the robot.
        goal: (..., n_v) goal values that are wanted, at one or several times.
        values: (..., n_v) goal values that are.
    """
    targets, now = positions_of(effectors, goal), positions_of(effectors, values)
    for i, effector in enumerate(effectors):
        if effector.has_position:
            wanted, own = effector.wanted, targets[..., i, :]  # (3,), (..., 3)
            shown = np.where(wanted, own, now[..., i, :]) if wanted.any() else np.nan
            is_known = np.isfinite(own[..., wanted]).all(axis=-1, keepdims=True)
            targets[..., i, :] = np.where(is_known, shown, own)
    return targets


def distance_between(effectors: tuple[DescribedEffector, ...], goal: Array, values: Array) -> float:
    """Largest distance [m] of effectors from their goals; NaN without any.

    Without volumes, rotations and components that are left free.

    Args:
        effectors: of the robot.
        goal: (n_v,) goal values that are wanted.
        values: (n_v,) goal values that are.
    """
    found = [
        float(np.linalg.norm((goal - values)[place][:3][effector.wanted]))
        for effector, place in zip(effectors, places_of(effectors), strict=True)
        if effector.kind != "volume" and effector.wanted.any()
    ]
    finite = [distance for distance in found if distance == distance]
    return max(finite, default=float("nan"))


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
        """Positions (..., p, 3) [m] among goal values (..., n_v); NaN for effectors without one."""
        return positions_of(self.robot.effectors, values)

    def targets(self, frame: ViewFrame) -> Array:
        """Where the targets of a frame are shown: (p, 3) [m]; NaN for effectors without a position."""
        return targets_of(self.robot.effectors, frame.goal, frame.values)

    def trails(self, frames: list[ViewFrame]) -> tuple[Array, Array]:
        """Where the targets of frames are shown, and positions of the effectors: (m, p, 3) [m] each."""
        shape = (len(frames), len(self.robot.rest))
        goal = np.array([one.goal for one in frames]).reshape(shape)
        values = np.array([one.values for one in frames]).reshape(shape)
        return targets_of(self.robot.effectors, goal, values), self.positions(values)

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
        modelled: (n_v,) goal values where the model that decides has the effectors; None: it is not known.
        obstacles: where those are that are not where the description has them, by name.
        decided: (n_a,) efforts that left, where `effort` is of a simulated robot [SI]; None: `effort` left.
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
    modelled: Array | None = None
    obstacles: Mapping[str, ObstaclePose] = field(default_factory=dict)
    decided: Array | None = None

    @property
    def nbytes(self) -> int:
        """Memory of its large arrays [bytes]."""
        geometry = self.geometry
        ghost = 0 if self.ghost is None else self.ghost.nbytes
        whole = geometry.vertices.nbytes + geometry.segments.nbytes + geometry.contacts.nbytes
        return ghost + whole
