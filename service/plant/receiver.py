"""What a stream of targets needs to know of a robot, from its file or from the node that serves it."""

from __future__ import annotations

import logging
import re
from dataclasses import dataclass

import numpy as np

from tauten.model import Robot, RobotFileError
from tauten.model.load import robot_path
from tauten.service.describing import describe
from tauten.service.plant.paths import PathSettings, make_path, path_from
from tauten.service.plant.waypoints import PathError, TargetPath
from tauten.service.process import StopFlag
from tauten.service.setup import load_setup
from tauten.service.wire import (
    Keys,
    Network,
    RobotDescription,
    Role,
    ask_description,
    session_of,
    wait_for,
)

log = logging.getLogger(__name__)

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")  # of a robot


@dataclass(frozen=True, slots=True, eq=False)
class Receiver:
    """A robot that targets are sent to.

    Attributes:
        description: of the robot.
        robot: its model; None where only the description of its node is known.
    """

    description: RobotDescription
    robot: Robot | None = None

    def number(self, effector: str) -> int:
        """Number of an effector.

        Raises:
            PathError: there is no effector of this name.
        """
        names = [one.name for one in self.description.effectors]
        if effector not in names:
            has = ", ".join(names)
            raise PathError(f"{self.description.name} has no effector {effector!r}, it has {has}")
        return names.index(effector)


def find_receiver(name: str, network: Network, stop: StopFlag) -> Receiver | None:
    """The robot of a file or of a shipped name, else the one that a node serves; None after a stop.

    Raises:
        RobotFileError: a robot file that cannot be used, or no name of a robot.
        NetworkError: no session, or a node that does not describe its robot.
    """
    try:
        robot_path(name)
    except RobotFileError:
        if not _NAME.fullmatch(name):
            raise
        log.info("no robot file %r here: its node is asked for its description", name)
        return described_receiver(name, network, stop)
    setup = load_setup(name, basis="none")
    return Receiver(describe(setup), setup.robot)


def described_receiver(name: str, network: Network, stop: StopFlag) -> Receiver | None:
    """The robot that a node serves, from its description, once the node is alive.

    Raises:
        NetworkError: no session, or no description.
    """
    keys = Keys(name)
    with session_of(network, Role.OTHER, name) as session:
        if not wait_for(session, keys.token, stop):
            return None
        return Receiver(ask_description(session, keys))


def receiver_path(name: str, receiver: Receiver, settings: PathSettings) -> TargetPath:
    """A path for a robot; "reach" needs its model.

    Raises:
        PathError: no such path, or one that cannot be made.
    """
    if receiver.robot is not None:
        return make_path(name, receiver.robot, settings)
    if name == "reach":
        raise PathError(
            f"reach is computed with the model of {receiver.description.name}: give its file, --robot FILE"
        )
    effector = receiver.description.effectors[settings.effector]
    return path_from(
        name, effector.kind, np.array(effector.rest), receiver.description.size, settings
    )
