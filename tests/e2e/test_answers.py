"""Questions to a node: answered one in a tick, and never in the way of targets and commands."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import zenoh
from support.faults import Proxy, Wire, client_config, start_router
from support.messages import encode_command
from support.nodes import follow, wait_mode
from support.processes import Process, Served, Start, wait_alive

from tauten.model import Robot
from tauten.service.link import close_session
from tauten.service.node.answers import QuestionAnswers
from tauten.service.plant import free_ports
from tauten.service.wire import (
    CDR,
    TEXT,
    CommandSubscriber,
    Keys,
    Mode,
    Network,
    OperatorCommand,
    Role,
    Tick,
    decode_tick,
    open_session,
    read_config,
)

KEYS = Keys("beam")
QUESTIONS = 200
PATIENCE = 20.0  # s; a test that waits for something fails after it
FLOOD = """\
import sys, time, zenoh
session = zenoh.open(zenoh.Config.from_file(sys.argv[1]))
key, rate, sent, begin = sys.argv[2], float(sys.argv[3]), 0, time.monotonic()
print("open", flush=True)
while True:
    session.get(key, handler=zenoh.handlers.RingChannel(1), timeout=1.0)
    sent += 1
    if sent % 30 == 0:
        time.sleep(max(sent / rate - (time.monotonic() - begin), 0.0))
    if sent % 300 == 0:
        print(sent / (time.monotonic() - begin), flush=True)
"""


@pytest.fixture
def sessions() -> Iterator[tuple[zenoh.Session, zenoh.Session]]:
    """A node's session and another one."""
    port = free_ports()
    found = [
        open_session(Network(port), role, "beam", connected=False)
        for role in (Role.NODE, Role.OTHER)
    ]
    yield found[0], found[1]
    for session in found:
        close_session(session)


def command_arrives(outside: zenoh.Session, commands: CommandSubscriber) -> bool:
    """Send commands until one has arrived."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        payload = encode_command(OperatorCommand.STOP)
        outside.put(KEYS.command, payload, encoding=f"{CDR};{TEXT}")
        time.sleep(0.02)
        if commands.read():
            return True
    return False


def test_questions_that_wait_do_not_keep_commands_out(
    sessions: tuple[zenoh.Session, zenoh.Session],
) -> None:
    inside, outside = sessions
    answers = QuestionAnswers(inside, "beam", b"{}")
    ring = zenoh.handlers.RingChannel(16)
    commands = CommandSubscriber(inside.declare_subscriber(KEYS.command, ring))
    assert command_arrives(outside, commands)
    requests = [
        outside.get(key, timeout=60.0)
        for _ in range(QUESTIONS)
        for key in (KEYS.metrics, KEYS.description)
    ]
    assert command_arrives(outside, commands)
    made = []

    def metrics() -> bytes:
        made.append(b"text")
        return made[-1]

    for count in range(1, 3):
        answers.answer_one(metrics)
        answers.answer_one(metrics)
        assert len(made) == count  # one of each kind
    for _ in range(QUESTIONS):
        answers.answer_one(metrics)
    assert len(made) < QUESTIONS / 10  # those the ring has kept
    end, replies = time.monotonic() + PATIENCE, []
    while len(replies) < 2 * len(made) and time.monotonic() < end:
        replies += [reply for one in requests if (reply := received(one)) is not None]
        time.sleep(0.01)
    texts = [bytes(reply.ok.payload) for reply in replies if reply.ok is not None]
    assert sorted(texts) == [b"text"] * len(made) + [b"{}"] * len(made)


@pytest.mark.realtime
def test_a_peer_that_asks_and_does_not_read_delays_no_tick(tmp_path: Path) -> None:
    port, between = free_ports(), free_ports()
    inside = open_session(Network(port), Role.NODE, "beam")
    proxy = Proxy(between, port)
    outside = zenoh.open(read_config(client_config(tmp_path / "client.json5", between)))
    try:
        answers, made, longest = QuestionAnswers(inside, "beam", b"{}"), [], 0.0

        def metrics() -> bytes:
            made.append(bytes(200_000))
            return made[-1]

        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and len(made) < 100:
            outside.get(KEYS.metrics, handler=zenoh.handlers.RingChannel(1), timeout=1.0)
            time.sleep(0.01)
            begin = time.monotonic()
            answers.answer_one(metrics)
            longest = max(longest, time.monotonic() - begin)
            if len(made) == 10:
                proxy.state = Wire.DEAF
        assert len(made) > 10  # questions have arrived from a peer that does not read
        assert longest < 0.2
    finally:
        outside.close()  # type: ignore[no-untyped-call]
        proxy.close()
        inside.close()  # type: ignore[no-untyped-call]


@pytest.mark.realtime
def test_behind_a_router_such_a_client_keeps_no_command_out(tmp_path: Path) -> None:
    port, between = free_ports(), free_ports()
    router = start_router(tmp_path / "router.txt", port)
    direct = client_config(tmp_path / "direct.json5", port)
    inside = open_session(Network(config=direct), Role.NODE, "beam")
    proxy = Proxy(between, port)
    viewer = zenoh.open(read_config(client_config(tmp_path / "viewer.json5", between)))
    operator = zenoh.open(read_config(direct))
    try:
        answers, made = QuestionAnswers(inside, "beam", b"{}"), []
        ring = zenoh.handlers.RingChannel(16)
        commands = CommandSubscriber(inside.declare_subscriber(KEYS.command, ring))
        assert command_arrives(operator, commands)

        def metrics() -> bytes:
            made.append(bytes(200_000))
            return made[-1]

        longest, sent, end = 0.0, 0.0, time.monotonic() + PATIENCE
        while time.monotonic() < end:
            viewer.get(KEYS.metrics, handler=zenoh.handlers.RingChannel(1), timeout=1.0)
            if not sent:
                sent = time.monotonic()
                payload = encode_command(OperatorCommand.STOP)
                operator.put(KEYS.command, payload, encoding=f"{CDR};{TEXT}")
            time.sleep(0.01)
            answers.answer_one(metrics)
            longest = max(longest, time.monotonic() - sent)
            if commands.read():
                sent = 0.0
            if len(made) == 10:
                proxy.state = Wire.DEAF
        assert len(made) > 10
        assert longest < 0.2
    finally:
        for session in (viewer, operator, inside):
            close_session(session)
        proxy.close()
        router.process.kill()
        router.process.wait()


def received(replies: object) -> zenoh.Reply | None:
    """A reply that has arrived; None without one, and after the last."""
    try:
        return replies.try_recv()  # type: ignore[attr-defined, no-any-return]
    except zenoh.ZError:
        return None


@pytest.fixture
def routed(beam_file: Path, tmp_path: Path, run: Start) -> Iterator[tuple[Served, Path]]:
    """A node behind a router, a session of an operator, and their configuration."""
    port = free_ports()
    router = start_router(tmp_path / "router.txt", port)
    config = client_config(tmp_path / "client.json5", port)
    log = tmp_path / "log.mcap"
    node = run("serve", beam_file, "--zenoh-config", config, "--record", log)
    session = zenoh.open(read_config(config))
    try:
        wait_alive(session, KEYS.token, node)
        yield Served(node, session, KEYS, port, log), config
    finally:
        close_session(session)
        router.process.kill()
        router.process.wait()


@pytest.mark.realtime
@pytest.mark.parametrize("key", [KEYS.metrics, KEYS.description])
def test_a_flood_of_questions_does_not_delay_a_stop(
    routed: tuple[Served, Path], beam: Robot, tmp_path: Path, key: str
) -> None:
    served, config = routed
    output = tmp_path / "flood.txt"
    with output.open("wb") as sink:
        command = [sys.executable, "-c", FLOOD, str(config), key, "3000"]
        flood = Process(subprocess.Popen(command, stdout=sink, stderr=sink), output)
    try:
        follow(served, beam, 4.0)
        wait_mode(served, Mode.HOLD)
        assert float(output.read_text().split()[-1]) > 2500.0, output.read_text()
        ticks = served.session.declare_subscriber(KEYS.tick, zenoh.handlers.RingChannel(100))
        time.sleep(0.5)
        begin = time.time_ns()
        served.session.put(
            KEYS.command, encode_command(OperatorCommand.STOP), encoding=f"{CDR};{TEXT}"
        )
        stopped = first_stop(ticks)
        assert 1e-9 * (stopped.stamp - begin) < 0.1
        assert served.process.end() == 0  # while the questions go on
    finally:
        flood.process.kill()
        flood.process.wait()


def first_stop(ticks: zenoh.Subscriber[object]) -> Tick:
    """The first tick of a stop."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        sample = ticks.try_recv()
        if sample is None:
            time.sleep(0.001)
            continue
        tick = decode_tick(bytes(sample.payload))
        assert isinstance(tick, Tick)
        if tick.mode is Mode.STOP:
            return tick
    raise AssertionError("the node does not stop")
