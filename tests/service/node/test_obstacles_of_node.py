"""A node with an obstacle whose poses arrive: contacts, wrenches and places leave it, and its log replays."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import zenoh
from support.messages import decoded_by_mcap
from support.processes import ROBOT, write_robot

from tauten.controller import Controller, warm_controller
from tauten.model import load_robot
from tauten.model.contact import pose_at
from tauten.service.describing import log_metadata
from tauten.service.log import LogReader, LogRecorder, record_robot
from tauten.service.node import Clock, ControlLoop, Node, Signals
from tauten.service.node.clock import Beat
from tauten.service.operate import read_contacts
from tauten.service.operate.contacts import Touched
from tauten.service.plant import free_ports
from tauten.service.process import StopFlag
from tauten.service.replay import replay
from tauten.service.setup import load_setup
from tauten.service.wire import (
    CDR,
    CONTACT_FIELDS,
    Cloud,
    EffectorMessage,
    Keys,
    Network,
    ObstacleState,
    OperatorCommand,
    Role,
    decode_cloud,
    decode_health,
    decode_obstacle,
    decode_wrench,
    encode_effector,
    open_session,
)

KEYS = Keys("beam")
TABLE = """
[[surfaces]]
name = "below"
box = { lower = [0.08, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }
normal = [0.0, 0.0, -1.0]

[[obstacles]]
name = "table"
shape = "plane"
position = [0.0, 0.0, -0.004]
parameters = { point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }
stream = { largest_speed = 0.1 }

[[contacts]]
candidates = "below"
against = "table"
points = "vertices"
"""


@dataclass
class Rig:
    """A node with a log, beats by hand, and a session outside."""

    node: Node
    clock: Clock
    outside: zenoh.Session
    recorder: LogRecorder
    log: Path

    def tick(self) -> None:
        self.node.tick(self.clock, Beat(0, 0.0, 0.01, 0), shutdown=False)

    def pose(self, height: float, stamp: int | None = None) -> None:
        """Send where the table is."""
        values = (0.0, 0.0, height, 1.0, 0.0, 0.0, 0.0)
        message = EffectorMessage(time.time_ns() if stamp is None else stamp, "beam_base", values)
        payload = encode_effector("frame", "table", message)
        self.outside.put(
            KEYS.obstacle("table"), payload, encoding=f"{CDR};geometry_msgs/msg/PoseStamped"
        )

    def until(self, done: Callable[[], bool], height: float | None = None) -> None:
        """Tick until something has happened; the table stands at a height."""
        end = time.monotonic() + 20.0
        while not done():
            assert time.monotonic() < end
            if height is not None:
                self.pose(height)
            time.sleep(0.005)
            self.tick()


class Reading(threading.Thread):
    """`tauten contacts` beside a node whose ticks are made by hand."""

    def __init__(self, session: zenoh.Session, pushing: bool = True) -> None:
        super().__init__(daemon=True)
        self.session, self.pushing = session, pushing
        self.found: Touched | None = None

    def run(self) -> None:
        self.found = read_contacts(self.session, "beam", self.pushing)


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    setup = load_setup(write_robot(tmp_path, ROBOT + TABLE), basis="full")
    port, log = free_ports(), tmp_path / "run.mcap"
    inside = open_session(Network(port), Role.NODE, "beam", connected=False)
    outside = open_session(Network(port), Role.OTHER, "beam", connected=False)
    controller = warm_controller(setup)
    recorder = LogRecorder(log, log_metadata(setup, controller.effector_values))
    loop = ControlLoop(controller, settings=setup.service)
    node = Node(setup, loop, inside, recorder, closed_loop=False)
    yield Rig(node, Clock(0.02, lambda: 0.0), outside, recorder, log)
    outside.close()  # type: ignore[no-untyped-call]
    inside.close()  # type: ignore[no-untyped-call]
    recorder.close()


def newest(source: zenoh.Subscriber[object], decode: Callable[[bytes], object]) -> list[object]:
    """All that has arrived, decoded."""
    found = []
    while (sample := source.try_recv()) is not None:
        found.append(decode(sample.payload.to_bytes()))
    return found


@pytest.mark.long
def test_a_table_that_is_lifted_pushes_the_model_and_the_log_replays(rig: Rig) -> None:
    channel = zenoh.handlers.RingChannel
    clouds, wrenches, places, health = (
        rig.outside.declare_subscriber(key, channel(1000))
        for key in (KEYS.contacts, KEYS.wrench("table"), KEYS.obstacle_state("table"), KEYS.health)
    )
    height, loop = -0.004, rig.node._loop

    def table() -> float:
        return float(loop.controller.obstacles.poses[0].position[2])

    for _ in range(3):  # within the robot: it does not appear there
        rig.pose(0.02)
        time.sleep(0.02)
        rig.tick()
    assert not loop.controller.obstacles.given[0]
    rig.until(lambda: loop.controller.obstacles.given[0], height)
    while height < 2e-3:
        height += 2e-4
        rig.pose(height)
        time.sleep(0.01)
        rig.tick()
    rig.until(lambda: abs(table() - 2e-3) < 1e-4 and loop.controller.lam_c.sum() > 0.0, 2e-3)
    rig.until(lambda: not loop.controller.obstacles.move, 2e-3)
    for _ in range(30):
        rig.pose(2e-3)
        time.sleep(0.005)
        rig.tick()
    lowest = loop.controller.robot.candidates(loop.controller.state)[:, 2].max()
    assert lowest > 1.5e-3, "the tip lies on the table"
    time.sleep(0.3)
    cloud = newest(clouds, lambda payload: decode_cloud(payload, CONTACT_FIELDS))[-1]
    assert isinstance(cloud, Cloud)
    columns = dict(zip(CONTACT_FIELDS, cloud.values.T, strict=True))
    assert len(cloud.values) >= 1
    np.testing.assert_allclose(columns["fz"].sum(), loop.controller.lam_c.sum(), rtol=1e-3)
    np.testing.assert_allclose(columns["nz"], 1.0)
    np.testing.assert_allclose(columns["z"], 2e-3, atol=3e-4)
    np.testing.assert_allclose(columns["gap"], 0.0, atol=3e-4)
    assert not columns["pair"].any()
    assert columns["sliding"].all()
    wrench = newest(wrenches, decode_wrench)[-1]
    assert isinstance(wrench, np.ndarray)
    np.testing.assert_allclose(wrench[:3], [0.0, 0.0, -columns["fz"].sum()], rtol=1e-3, atol=1e-9)
    torque = -np.cross(cloud.values[:, :3], cloud.values[:, 3:6]).sum(axis=0)
    np.testing.assert_allclose(wrench[3:], torque, rtol=1e-2, atol=1e-6)
    place = newest(places, decode_obstacle)[-1]
    assert isinstance(place, ObstacleState)
    assert place.pose.position[2] == pytest.approx(2e-3, abs=2e-4)
    reading = Reading(rig.outside)
    reading.start()
    rig.until(lambda: not reading.is_alive(), 2e-3)
    assert reading.found is not None
    assert reading.found.pair_of(0) == "below on table"
    np.testing.assert_allclose(reading.found.column("fz").sum(), columns["fz"].sum(), rtol=0.1)
    others = Reading(rig.outside, pushing=False)
    others.start()
    rig.until(lambda: not others.is_alive(), 2e-3)
    assert others.found is not None and len(others.found.values) > 0
    assert not others.found.column("fz").any() and (others.found.column("gap") > -1e-4).all()
    assert len(others.found.values) + len(columns["fz"]) == len(loop.controller.contacts)
    # hostile ones
    for wrong in (np.nan, 1.0, 2e-3):
        rig.pose(wrong, time.time_ns() - 10**10 if wrong == 2e-3 else None)
    before = table()
    for _ in range(5):
        time.sleep(0.01)
        rig.tick()
    assert table() == pytest.approx(before, abs=1e-3)
    said = {}

    def counted() -> bool:
        for found in newest(health, decode_health):
            assert isinstance(found, dict)
            said.update(found)
        return "obstacles" in said and int(said["obstacles"].values["refused"]) >= 3

    rig.until(counted)
    rig.until(lambda: counted() and said["obstacles"].values["silent"] == "table")
    assert float(said["contacts"].values["below on table [N]"]) > 0.0
    stop = StopFlag()
    stop.requested = True
    rig.node.run(stop)
    rig.recorder.close()
    keys = {message.key for message in LogReader(rig.log).messages()}
    assert {KEYS.contacts, KEYS.wrench("table"), KEYS.obstacle_state("table")} <= keys
    again = replay(rig.log, 1e-9)
    assert again.same
    assert again.ticks > 50


def test_an_obstacle_stays_in_a_reset_where_it_was_seen(tmp_path: Path) -> None:
    """The model forgets what it did, not what is around it: no pose need arrive for a while."""
    loop = ControlLoop(Controller(load_robot(write_robot(tmp_path, ROBOT + TABLE))))
    seen, start = pose_at([0.0, 0.0, -0.003]), loop.controller.obstacles
    assert start.poses[0].position[2] == -0.004 and not start.given[0]
    loop.prepare({"table": seen})
    assert loop.obey(OperatorCommand.STOP) is None
    while not loop.released:
        loop.tick(None, Signals(target=False))
        loop.prepare()
    assert loop.obey(OperatorCommand.RESET) is None
    for _ in range(2):
        assert loop.controller.obstacles.poses[0].position[2] == -0.003
        assert loop.controller.obstacles.given[0]
        loop.tick(None, Signals(target=False))
        loop.prepare()


@pytest.mark.long
def test_a_recorder_beside_the_node_has_contacts_and_obstacles_too(
    rig: Rig, tmp_path: Path
) -> None:
    """It left them out, as it still does with the surface, which the node need not make for it."""
    log, stop = tmp_path / "beside.mcap", StopFlag()
    recording = threading.Thread(target=record_robot, args=(rig.outside, "beam", log, stop))
    recording.start()
    table = rig.node._loop.controller
    try:
        rig.until(lambda: log.exists() and table.obstacles.given[0], -0.004)
        rig.until(lambda: len(table.contacts) > 0, -0.001)
        for _ in range(20):
            rig.until(lambda: True, -0.001)
            time.sleep(0.005)
            rig.tick()
        time.sleep(0.2)
        assert rig.node._outputs._open.has_subscribers
        assert not rig.node._shape._surface.has_subscribers
    finally:
        stop.request()
        recording.join()
    found = {topic: (kind, message) for topic, kind, message in decoded_by_mcap(log)}
    kinds = {topic.removeprefix("/tauten/beam/"): kind for topic, (kind, _) in found.items()}
    assert kinds["contacts"] == kinds["open_contacts"] == "sensor_msgs/msg/PointCloud2"
    assert kinds["wrench/table"] == "geometry_msgs/msg/WrenchStamped"
    assert kinds["obstacle/table"] == "geometry_msgs/msg/PoseStamped"
    assert kinds["obstacle_state/table"] == "nav_msgs/msg/Odometry"
    assert "surface" not in kinds
    asked, model = (found[f"/tauten/beam/{key}/table"][1] for key in ("obstacle", "obstacle_state"))
    assert asked.pose.position.z == -0.001
    assert model.pose.pose.position.z == pytest.approx(-0.001, abs=1e-3)
