"""A robot file that has changed since a node was started: other processes of the same name say so."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from support.nodes import answering
from support.processes import ROBOT, write_robot

from tauten.model.numerics import Array
from tauten.service.describing import describe
from tauten.service.drive import Driver, Measured, run_driver
from tauten.service.link import NetworkError
from tauten.service.plant import (
    StreamSettings,
    TargetPath,
    free_ports,
    stream,
)
from tauten.service.process import StopFlag
from tauten.service.setup import load_setup
from tauten.service.wire import (
    CDR,
    Joints,
    Keys,
    Network,
    RobotDescription,
    Role,
    encode_joints,
    session_of,
)

OTHER = ROBOT.replace('"tip"', '"end"')
WIDER = ROBOT.replace("max_pull = 0.02", "max_pull = 0.03", 1)


class Idle(Driver):
    """Hardware that must not move."""

    def configure(self, robot: RobotDescription, options: Mapping[str, str]) -> None:
        pass

    def activate(self) -> None:
        raise AssertionError("it is to move nothing")

    def read(self) -> Measured:
        return Measured(*np.zeros((2, 2)))

    def write(self, position: Array, effort: Array) -> None:
        pass

    def deactivate(self) -> None:
        pass


def described(folder: Path, text: str = ROBOT) -> RobotDescription:
    """A robot by its file."""
    folder.mkdir()
    return describe(load_setup(write_robot(folder, text)))


@pytest.mark.long
@pytest.mark.parametrize(
    ("text", "said"), [(OTHER, "effectors end"), (WIDER, r"actuators .* 0\.03 m")]
)
def test_targets_and_plants_of_a_changed_file_are_refused(
    tmp_path: Path, text: str, said: str
) -> None:
    """Targets of another effector moved the node's first one, and measurements of another corrected it."""
    served, own = described(tmp_path / "served", text), described(tmp_path / "own")
    network, stop = Network(free_ports()), StopFlag()
    path = TargetPath(np.array([0.0, 1.0]), np.zeros((2, 3)), repeats=False)
    settings = StreamSettings(rate=50.0, duration=0.1, json=False, effector=0, await_plant=False)
    joints = Joints(time.time_ns(), own.frame, ("lower", "upper"), (1e-3, 0.0), (1.0, 0.0))
    with answering(served, network.port or 0) as session:
        with pytest.raises(
            NetworkError, match=f"the node of 'beam' has the {said}.* start both again"
        ):
            stream(own, path, settings, network, stop)

        def publish() -> None:
            while not stop.requested:
                session.put(Keys("beam").actuation, encode_joints(joints), encoding=CDR)
                time.sleep(0.02)

        publishing = threading.Thread(target=publish)
        publishing.start()
        try:
            with (
                session_of(network, Role.PLANT, "beam") as other,
                pytest.raises(NetworkError, match=said),
            ):
                run_driver(other, own, Idle(), False, stop)
        finally:
            stop.request()
            publishing.join()


def test_the_same_file_is_followed(tmp_path: Path) -> None:
    robot, network = described(tmp_path / "own"), Network(free_ports())
    path = TargetPath(np.array([0.0, 1.0]), np.zeros((2, 3)), repeats=False)
    settings = StreamSettings(rate=50.0, duration=0.1, json=False, effector=0, await_plant=False)
    with answering(robot, network.port or 0):
        assert stream(robot, path, settings, network, StopFlag()) > 0
