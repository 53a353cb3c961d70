"""Poses and distances over real Zenoh: streamed, refused, recorded, replayed and reported."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from support.messages import Point, decoded_by_mcap, encode_point
from support.nodes import check_limits, wait_for, wait_health
from support.processes import (
    ROBOT,
    Process,
    Served,
    Start,
    client_of,
    run_main,
    start,
    wait_alive,
    write_robot,
)

from tauten.model import Robot, Simulator, load_robot
from tauten.model.numerics import Array
from tauten.service.codec.messages import POINT, POSE
from tauten.service.link import close_session
from tauten.service.log import Logged, LogReader
from tauten.service.plant import TargetPath, free_ports, save_path
from tauten.service.replay import make_report, read_run
from tauten.service.wire import (
    CDR,
    JOINTS,
    JSON,
    EffectorMessage,
    Joints,
    Keys,
    Mode,
    decode_effector,
    decode_joints,
    effector_json,
    encode_effector,
)

EFFECTORS = """\
[[effectors]]
name = "tool"
kind = "frame"
region = { lower = [0.099, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }

[[effectors]]
name = "span"
kind = "distance"
point = [0.1, 0.01, 0.018]
other = [0.05, 0.01, 0.018]
"""
TOOL = "tauten/beam/plant/effector"


@pytest.fixture
def robot_file(tmp_path: Path) -> Path:
    return write_robot(tmp_path, ROBOT.split("[[effectors]]", maxsplit=1)[0] + EFFECTORS)


@pytest.fixture
def robot(robot_file: Path) -> Robot:
    return load_robot(robot_file)


@pytest.fixture
def served(robot_file: Path, tmp_path: Path) -> Iterator[Served]:
    """A node in closed loop, and a plant a tenth stiffer whose winches pull forces."""
    port, log = free_ports(), tmp_path / "log.mcap"
    serving = ("serve", robot_file, "--port", port, "--record", log, "--closed-loop")
    behaving = ("--measure", "--young-scale", "1.1", "--drive", "tension")
    node = start(tmp_path / "serve.txt", *serving)
    plant = start(tmp_path / "plant.txt", "plant", robot_file, "--port", port, *behaving)
    session = client_of(node, port)
    try:
        wait_alive(session, Keys("beam").token, node)
        wait_alive(session, Keys("beam").plant_token, plant)
        yield Served(node, session, Keys("beam"), port, log)
    finally:
        close_session(session)
        for process in (node, plant):
            if process.process.poll() is None:
                process.process.kill()
            process.process.wait()


def goal_of(robot: Robot) -> Array:
    """Goal values where the upper cable is pulled by 4 mm."""
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(position=[0.0, 0.004]).converged
    return simulator.effector_values


def stream_csv(robot: Robot, goal: Array, folder: Path) -> list[Path]:
    """A file with constant targets for each effector."""
    files = []
    layout = robot.effector_layout
    for i, (name, kind) in enumerate(zip(layout.names, layout.kinds, strict=True)):
        values = np.tile(goal[layout.values_of(i)], (2, 1))
        files.append(folder / f"{name}.csv")
        save_path(TargetPath(np.array([0.0, 1.0]), values, True, kind), files[-1])
    return files


def wait_pose(served: Served, goal: Array) -> None:
    """Wait until the plant's tool is within 0.3 mm and 3 mrad of a pose."""

    def near(payload: bytes) -> bool:
        found = decode_effector("frame", "tool", payload, CDR)
        assert isinstance(found, EffectorMessage)
        values = np.array(found.values)
        angle = 2.0 * np.arccos(min(abs(float(values[3:] @ goal[3:7])), 1.0))
        return bool(np.linalg.norm(values[:3] - goal[:3]) < 3e-4 and angle < 3e-3)

    wait_for(served, TOOL, near, "the tool at its pose")


def wait_span(served: Served, goal: Array) -> None:
    """Wait until spans are streamed, and the plant's is within 0.1 mm of its target."""
    wait_for(served, "tauten/beam/target/span", lambda payload: True, "a stream of spans")

    def near(payload: bytes) -> bool:
        found = decode_effector("distance", "span", payload, CDR)
        assert isinstance(found, EffectorMessage)
        return abs(found.values[0] - goal[7]) < 1e-4

    wait_for(served, f"{TOOL}/span", near, "the span at its length")


def refused_messages(robot: Robot, goal: Array) -> list[tuple[str, bytes, str]]:
    """Key, payload and encoding of targets that no effector may follow."""
    tool, span = Keys("beam").targets(robot.effector_names)
    x, y, z = goal[:3].tolist()
    pose = goal[:7].tolist()
    turned = EffectorMessage(0, "", (*pose[:3], 2.0, 0.0, 0.0, 0.0))
    lost = EffectorMessage(0, "", (*pose[:6], float("nan")))
    far = EffectorMessage(0, "", (*pose[:2], 10.0, *pose[3:]))
    return [
        (tool, encode_point(Point(0, "", (x, y, z))), f"{CDR};{POINT}"),
        (tool, encode_point(Point(0, "", (x, y, z))), CDR),
        (tool, json.dumps({"point": {"x": x, "y": y, "z": z}}).encode(), JSON),
        (tool, encode_effector("frame", "tool", turned), CDR),
        (tool, encode_effector("frame", "tool", lost), f"{CDR};{POSE}"),
        (tool, effector_json("frame", "tool", far), JSON),
        (span, encode_effector("distance", "other", EffectorMessage(0, "", (0.05,))), CDR),
        (span, effector_json("distance", "span", EffectorMessage(0, "", (-0.05,))), JSON),
        (span, effector_json("distance", "span", EffectorMessage(0, "", (0.05, 0.1))), JSON),
        (span, effector_json("frame", "tool", turned), JSON),
    ]


@pytest.mark.long
def test_poses_and_distances_are_followed_refused_recorded_and_replayed(
    served: Served, robot: Robot, robot_file: Path, run: Start, tmp_path: Path
) -> None:
    goal = goal_of(robot)
    streams: list[Process] = []
    for name, file in zip(robot.effector_names, stream_csv(robot, goal, tmp_path), strict=True):
        options = ("--robot", robot_file, "--effector", name, "--repeat", "--port", served.port)
        streams.append(run("stream", file, *options, *(["--json"] if name == "tool" else [])))
    wait_pose(served, goal)
    wait_span(served, goal)
    for key, payload, encoding in refused_messages(robot, goal):
        served.session.put(key, payload, encoding=encoding)
    counts = wait_health(
        served, lambda found: int(found["targets"].values.get("refused", "0")) >= 10
    )["targets"].values
    assert counts["refused_wrong_type"] == "3"
    assert counts["refused_no_rotation"] == "1"
    assert counts["refused_not_finite"] == "1"
    assert counts["refused_out_of_reach"] == "2"
    assert counts["refused_wrong_shape"] == "2"
    assert counts["refused_malformed"] == "1"
    assert all(stream.end() == 0 for stream in streams)
    assert served.process.end() == 0
    check_log(served.log, robot, goal, tmp_path)


def check_log(log: Path, robot: Robot, goal: Array, folder: Path) -> None:
    """The log has the goals, replays to the same decisions, and its report has both errors."""
    found = read_run(log)
    assert found.kind == "frame"
    following = [tick for tick in found.ticks if tick.mode is Mode.RUN]
    # at the end one stream is too old before the other, and its effector stays where the model has it
    last = [tick for tick in following if np.allclose(tick.goal_values, goal, atol=1e-9)][-1]
    assert len(last.correction_values) == robot.layout.n_e == 7
    assert np.abs(last.correction_values).max() > 1e-5
    np.testing.assert_allclose(last.goal[0], goal[:3], atol=1e-9)
    report = make_report(found)
    assert report.plant_error.rms_mrad is not None
    assert report.model_plant_error.max_mrad is not None
    assert 0.0 < report.model_plant_error.max_mrad < 300.0
    again = ("--recorded-paths", "--tolerance", 1e-9, "--report", folder / "report")
    assert run_main("replay", log, *again) == 0  # decides the same
    joints = [
        decode_joints(message.payload, CDR, robot.actuators.names)
        for message in messages(log)
        if message.key.endswith("/actuation")
    ]
    assert all(isinstance(joint, Joints) for joint in joints)
    check_limits(joints, robot)  # type: ignore[arg-type]
    # one came as JSON, the other as CDR
    kinds = {topic: kind for topic, kind, _ in decoded_by_mcap(log) if "/target" in topic}
    assert kinds == {"/tauten/beam/target": POSE, "/tauten/beam/target/span": JOINTS}


def messages(log: Path) -> list[Logged]:
    return list(LogReader(log).messages())
