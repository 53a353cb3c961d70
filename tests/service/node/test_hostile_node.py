"""The whole node with random messages in random order: every message that it publishes is checked.

The node's own code with real Zenoh sessions, its beats given by hand so that hundreds of runs take
seconds.
"""

from __future__ import annotations

import json
import queue
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import zenoh
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from support.messages import Point, decode_point, encode_command, encode_point

from tauten.controller import warm_controller
from tauten.service.codec.messages import POINT
from tauten.service.log import Entry
from tauten.service.node import Clock, ControlLoop, Node
from tauten.service.node.clock import Beat
from tauten.service.plant import free_ports
from tauten.service.setup import load_setup
from tauten.service.wire import (
    CDR,
    JSON,
    TEXT,
    Joints,
    Keys,
    Mode,
    Network,
    OperatorCommand,
    Role,
    Tick,
    decode_joints,
    decode_tick,
    open_session,
)

KEYS = Keys("beam")
TARGET, MEASURED = KEYS.targets(("tip", "middle")), KEYS.measurements(("tip", "middle"))
ROUNDING = 1e-12
PROBE = "probe/of/this/test"  # messages of a session arrive in order
RELEASED = 60  # ticks, in which a stop has let the cables out
PATIENCE = 60.0  # s, for a message on a machine that is busy with something else


class Seen:
    """Keeps what the node hands to its log: every message that leaves, none lost on the way."""

    dropped, fault = 0, ""

    def __init__(self) -> None:
        self.entries: list[Entry] = []

    def write(self, entry: Entry) -> None:
        self.entries.append(entry)

    def take(self, key: str) -> list[bytes]:
        return [entry.payload for entry in self.entries if entry.key == key]


@dataclass
class Rig:
    """A node, what leaves it, and a session of those who send."""

    node: Node
    clock: Clock
    outside: zenoh.Session
    seen: Seen
    position: np.ndarray
    probed: queue.SimpleQueue[bytes]
    probes: int = 0

    def send(self, messages: list[tuple[str, bytes, str]]) -> None:
        """Send messages and wait until they are there, however busy the machine is."""
        for key, payload, encoding in messages:
            self.outside.put(key, payload, encoding=encoding)
        self.probes += 1
        number = str(self.probes).encode()
        self.outside.put(PROBE, number)
        while self.probed.get(timeout=PATIENCE) != number:
            pass

    def tick(self, slack: float = 0.01) -> None:
        """One tick of the node."""
        self.node.tick(self.clock, Beat(0, max(-slack, 0.0), slack, 0), shutdown=False)

    def follow_and_hold(self) -> None:
        """Bring the node from any mode to following a target, and to a hold by command."""
        for _ in range(RELEASED):
            self.send([order(OperatorCommand.RESET)])
            self.tick()
            if self.node._loop.state.mode is not Mode.STOP:
                break
        for _ in range(5):
            at = self.node._loop.controller.effector
            places = [encode_point(Point(0, "", tuple(point))) for point in at]
            sent = zip([*MEASURED, *TARGET], [*places, *places], strict=True)
            self.send([(key, payload, f"{CDR};{POINT}") for key, payload in sent])
            self.tick()
        self.send([order(OperatorCommand.HOLD)])
        self.tick()
        self.send([order(OperatorCommand.ENABLE)])
        last = self.seen.take(KEYS.actuation)[-1]
        joints = decode_joints(last, CDR, self.node._robot.actuators.names)
        assert isinstance(joints, Joints)
        self.position = np.array(joints.position)


def order(command: OperatorCommand) -> tuple[str, bytes, str]:
    return KEYS.command, encode_command(command), f"{CDR};{TEXT}"


@pytest.fixture(scope="module")
def rig(beam_file: Path) -> Iterator[Rig]:
    setup, port, seen = load_setup(beam_file), free_ports(), Seen()
    inside = open_session(Network(port), Role.NODE, "beam", connected=False)
    outside = open_session(Network(port), Role.OTHER, "beam", connected=False)
    node = Node(
        setup,
        ControlLoop(warm_controller(setup), settings=setup.service),
        inside,
        seen,
        closed_loop=True,
    )
    found = Rig(node, Clock(0.02), outside, seen, np.zeros(2), queue.SimpleQueue())
    probe = inside.declare_subscriber(PROBE, lambda sample: found.probed.put(bytes(sample.payload)))
    heard = outside.declare_subscriber(KEYS.tick, zenoh.handlers.RingChannel(1))
    while heard.try_recv() is None:  # until the two have met
        node.tick(found.clock, Beat(0, 0.0, 0.01, 0), shutdown=False)
        time.sleep(0.02)
    heard.undeclare()  # type: ignore[no-untyped-call]
    while found.probed.empty():  # until the probes are heard
        outside.put(PROBE, b"")
        time.sleep(0.02)
    yield found
    probe.undeclare()  # type: ignore[no-untyped-call]
    outside.close()  # type: ignore[no-untyped-call]
    inside.close()  # type: ignore[no-untyped-call]


numbers = st.floats() | st.floats(-0.2, 0.2) | st.floats(0.0, 0.12)
frames = st.sampled_from(["", "beam_base", "map"])
points = st.builds(
    lambda stamp, frame, xyz: encode_point(Point(stamp, frame, xyz)),
    st.integers(0, 2**31 * 10**9 - 1), frames, st.tuples(numbers, numbers, numbers),
)  # fmt: skip
commands = st.sampled_from([encode_command(command) for command in OperatorCommand])
payloads = points | commands | st.binary(max_size=120)
keys = st.sampled_from([*TARGET, *TARGET, *MEASURED, KEYS.command])
encodings = st.sampled_from([f"{CDR};{POINT}", f"{CDR};{TEXT}", CDR, JSON, "text/plain"])
slacks = st.sampled_from([0.01, 0.01, 0.01, -0.005, -0.1])
# a good measurement or target now and then, so that the node does follow
good = st.tuples(
    st.sampled_from([*TARGET, *MEASURED]),
    st.builds(
        lambda x, z: encode_point(Point(0, "", (0.1 + x, 0.01, 0.01 + z))),
        st.floats(-0.02, 0.0), st.floats(-0.03, 0.03),
    ),
    st.just(f"{CDR};{POINT}"),
)  # fmt: skip
orders = st.tuples(st.just(KEYS.command), commands, st.just(f"{CDR};{TEXT}"))
messages = good | good | good | orders | st.tuples(keys, payloads, encodings)
events = st.lists(st.tuples(st.lists(messages, max_size=4), slacks), min_size=20, max_size=60)


@settings(
    max_examples=15,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(wanted=events)
def test_everything_that_leaves_is_within_the_limits(
    rig: Rig, wanted: list[tuple[list[tuple[str, bytes, str]], float]]
) -> None:
    robot = rig.node._robot
    limits = robot.limits
    rig.follow_and_hold()
    rig.seen.entries.clear()
    for sent, slack in wanted:
        rig.send(sent)
        rig.tick(slack)
    ticks = [decode_tick(payload) for payload in rig.seen.take(KEYS.tick)]
    assert len(ticks) == len(wanted)
    assert all(isinstance(tick, Tick) for tick in ticks)
    # what was not decided for is no goal: a replay decides wherever there is one
    assert all(bool(tick.goal_values) == bool(tick.status) for tick in ticks)
    actuation = rig.seen.take(KEYS.actuation)
    assert len(actuation) == len(wanted)
    for payload in actuation:
        joints = decode_joints(payload, CDR, robot.actuators.names)
        assert isinstance(joints, Joints), joints
        assert joints.frame == robot.frame
        position, effort = np.array(joints.position), np.array(joints.effort)
        step, rig.position = np.abs(position - rig.position), position
        assert (limits.position_min <= position).all()
        assert (position <= limits.position_max).all()
        assert (limits.effort_min <= effort).all()
        assert (effort <= limits.effort_max).all()
        assert (step <= limits.rate * robot.h * (1.0 + ROUNDING)).all()
    for payload in rig.seen.take(KEYS.effectors(("tip",))[0]):
        assert isinstance(decode_point(payload, CDR), Point)


def test_those_runs_did_move_the_cables(rig: Rig) -> None:
    """The test above has followed targets, held, stopped and been reset, or it showed nothing."""
    modes = rig.node._statistics._modes
    assert all(modes[mode] > 0 for mode in ("idle", "run", "hold", "stop")), modes


def test_a_stop_among_many_commands_is_obeyed(rig: Rig) -> None:
    """Of more than sixteen in a tick, which may be long, the oldest were lost unread, a stop as well."""
    rig.follow_and_hold()
    locks = [json.dumps({"data": f"lock upper position {1e-5 * i}"}).encode() for i in range(100)]
    rig.send([order(OperatorCommand.STOP), *((KEYS.command, one, JSON) for one in locks)])
    rig.tick()
    assert rig.node._loop.state.mode is Mode.STOP


def test_refused_commands_do_not_fill_the_log(rig: Rig, caplog: pytest.LogCaptureFixture) -> None:
    """A flood of locks with long names: health counts all, the log has a line of bounded length a second."""
    begin, before = time.monotonic(), rig.node._inputs._commands.counts.refused.total()
    rig.node._inputs._next_line = 0.0  # no line before
    for number in range(40):
        words = (f"lock {'x' * 15_000}{number} position 1", f"unlock {'y' * (50 + number)}")
        rig.send([(KEYS.command, json.dumps({"data": one}).encode(), JSON) for one in words])
        rig.tick()
    seconds = time.monotonic() - begin
    counts = rig.node._inputs._commands.counts
    assert counts.refused.total() - before == 80
    assert len(counts.last_rejection) < 300
    lines = [record.getMessage() for record in caplog.records if "refused" in record.getMessage()]
    assert 1 <= len(lines) <= 2 + seconds
    assert max(map(len, lines)) < 400
