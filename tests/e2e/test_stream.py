"""`tauten stream`: a robot that is served is found by its name, without its file."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.nodes import wait_mode
from support.processes import Served, run_main, start

from tauten.service.plant import PathError, PathSettings, find_receiver, receiver_path
from tauten.service.process import StopFlag
from tauten.service.wire import Mode, Network


def test_targets_of_a_served_robot_need_no_robot_file(served: Served, tmp_path: Path) -> None:
    arguments = ("--robot", "beam", "--port", served.port, "--duration", 2.0)
    stream = start(tmp_path / "stream.txt", "stream", "line", "--size", 0.004, *arguments)
    wait_mode(served, Mode.RUN)
    assert stream.process.wait(30.0) == 0, stream.output.read_text()
    assert "targets sent" in stream.output.read_text()
    assert run_main("stream", "line", "--effector", "toe", *arguments) == 2


def test_reach_needs_the_file(served: Served) -> None:
    receiver = find_receiver("beam", Network(served.port), StopFlag())
    assert receiver is not None
    assert receiver.effectors == ("tip", "middle")
    assert receiver.robot is None
    with pytest.raises(PathError, match="reach is computed with the model of beam: give its file"):
        receiver_path("reach", receiver, PathSettings())
