"""A run that was recorded: its controller runs again on the log, as in `tauten replay`, and gives frames."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tauten.model import skin_of
from tauten.service.describing import describe
from tauten.service.frames.frame import RobotLook, ViewFrame
from tauten.service.link import Keys
from tauten.service.log import LogError, LogReader
from tauten.service.replay import (
    CHANGED,
    actions,
    changes,
    has_changed,
    recorded_setup,
    recorded_ticks,
    replay_loop,
)

FRAMES = 30.0  # a second of the run at most


class RecordedRobot:
    """The robot of a log. A log has no meshes: the model gives them.

    Attributes:
        look: what of the robot does not change.
        notes: what has changed since the log was made.
    """

    def __init__(
        self, path: Path, against: str | None = None, recorded_paths: bool = False
    ) -> None:
        """Read the log's metadata and load its robot; arguments as of `replay`.

        Raises:
            LogError: no log, a damaged one, or one without what a replay needs.
            RobotFileError, MeshError, BasisError, StateBasisError: the robot cannot be used.
        """
        self._reader = LogReader(path)
        recorded = recorded_setup(path, self._reader.read_metadata())
        self._setup = recorded.load(against, None, recorded_paths)
        self._then, robot = recorded.description, self._setup.robot
        self._skin = skin_of(robot)
        vertices = self._skin.geometry(robot, robot.rest(), None).vertices
        self.look = RobotLook(describe(self._setup), vertices)
        self.notes: tuple[str, ...] = ()
        if has_changed(self._then, robot):
            self.notes = (CHANGED,)

    def count(self) -> int:
        """Number of ticks of the log, and so of what `frames` gives.

        Raises:
            LogError: a damaged log.
        """
        key = Keys(self._then.name).tick
        return sum(message.key == key for message in self._reader.messages())

    def frames(self) -> Iterator[ViewFrame | None]:
        """A frame of each tick; None where there would be more than 30 a second.

        Raises:
            LogError: a damaged log, or one that does not fit the robot.
        """
        setup = self._setup
        loop = replay_loop(setup)
        every = max(round(setup.robot.integration.rate / FRAMES), 1)
        ticks = recorded_ticks(self._reader, setup, self._then.name)
        first: int | None = None
        for tick, joints, action in actions(ticks, loop):
            first = tick.stamp if first is None else first
            if tick.index % every:
                yield None
                continue
            controller = loop.controller
            values = action.actuation.effector_values
            yield ViewFrame(
                time=1e-9 * (tick.stamp - first),
                mode=tick.mode,
                cause=tick.cause,
                status=tick.status,
                geometry=self._skin.geometry(
                    controller.robot, controller.state, controller.contacts
                ),
                position=np.array(joints.position),
                effort=np.array(joints.effort),
                goal=np.array(tick.goal_values) if tick.goal else np.full_like(values, np.nan),
                values=values,
                step=tick.step,
                obstacles=controller.obstacles.by_name,
            )
        if first is None:
            raise LogError(f"{self._reader.path}: no tick in it to show")
        self.notes += tuple(changes(self._reader, self._then, setup)) if not self.notes else ()
