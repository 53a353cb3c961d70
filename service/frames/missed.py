"""Whether a target is out of reach: where a robot that follows it has come to rest elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array
from tauten.service.frames.frame import RobotLook, ViewFrame, positions_of, targets_of
from tauten.service.wire import Mode

RESTED = 1.0  # s of frames that are looked at
_LEAST = 0.7  # s of frames, at least
_FAR = 0.01  # of the robot's size: targets that are nearer count as reached
_STILL = 0.001  # of the robot's size, within which the effector stays


@dataclass(frozen=True, slots=True)
class Miss:
    """A target that is out of reach.

    Attributes:
        effector: its number.
        target: (3,) [m].
        nearest: (3,) where the robot gets [m].
    """

    effector: int
    target: Array
    nearest: Array

    @property
    def distance(self) -> float:
        """From the target to where the robot gets [m]."""
        return float(np.linalg.norm(self.target - self.nearest))


def missed(look: RobotLook, frames: list[ViewFrame]) -> Miss | None:
    """The farthest target that the robot stays away from; None where it moves, or is near all targets.

    Where the model that decides is known, as in a simulation, it is the model that has to stay away: a robot
    that differs from its model misses targets within reach, too.
    """
    if len(frames) < 2 or frames[-1].time - frames[0].time < _LEAST:
        return None
    if any(frame.mode is not Mode.RUN for frame in frames):
        return None
    effectors, size, last = look.robot.effectors, look.robot.size, frames[-1]
    deciding = [frame.values if frame.modelled is None else frame.modelled for frame in frames]
    places = np.array([positions_of(effectors, one) for one in deciding])  # (m, p, 3)
    moved = np.ptp(places, axis=0).max(axis=1)  # (p,)
    wanted = np.array([frame.goal for frame in frames])  # (m, n_v)
    if not np.abs(wanted - last.goal).max() <= _STILL * size:
        return None
    targets = targets_of(effectors, last.goal, deciding[-1])
    found = [
        Miss(i, targets[i], places[-1, i])
        for i in range(len(effectors))
        if np.linalg.norm(targets[i] - places[-1, i]) > _FAR * size and moved[i] <= _STILL * size
    ]
    return max(found, key=lambda one: one.distance, default=None)
