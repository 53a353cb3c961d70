"""What must hold when the network breaks: routers killed, wires cut, two nodes for one robot."""

from __future__ import annotations

import json
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import zenoh
from support.faults import Proxy, Wire, client_config, start_router
from support.nodes import check_limits, follow, modes, recorded, whole
from support.processes import START, Process, Served, Start, wait_alive

from tauten.model import Robot
from tauten.service.link import close_session
from tauten.service.plant import free_ports
from tauten.service.wire import Cause, Keys, Mode, Tick, read_config

KEYS = Keys("beam")


@pytest.fixture
def routed(beam_file: Path, tmp_path: Path, run: Start) -> Iterator[tuple[Served, Process, Path]]:
    """A router as a process, a node and a session that are its clients, and their configuration."""
    port, log = free_ports(), tmp_path / "log.mcap"
    router = start_router(tmp_path / "router.txt", port)
    config = client_config(tmp_path / "client.json5", port)
    node = run("serve", beam_file, "--zenoh-config", config, "--record", log)
    session = zenoh.open(read_config(config))
    try:
        wait_alive(session, KEYS.token, node)
        yield Served(node, session, KEYS, port, log), router, config
    finally:
        close_session(session)
        router.process.kill()
        router.process.wait()


def check_lost_and_found(served: Served, beam: Robot) -> list[Tick]:
    """A log without gaps, within limits, of a node that followed, held without targets, followed again."""
    ticks, joints, _ = recorded(served.log, beam)
    assert whole(ticks)
    check_limits(joints, beam)
    seen = [item for item in modes(ticks) if item[0] is not Mode.IDLE]
    lost = (Mode.HOLD, Cause.NO_TARGET)
    assert seen[:3] == [(Mode.RUN, Cause.NONE), lost, (Mode.RUN, Cause.NONE)]
    return ticks


@pytest.mark.slow
@pytest.mark.realtime
def test_a_killed_router_holds_until_there_is_one_again(
    routed: tuple[Served, Process, Path], beam: Robot, tmp_path: Path
) -> None:
    served, router, _ = routed
    follow(served, beam, 1.0)
    router.end(signal.SIGKILL)
    follow(served, beam, 1.5)  # into the void
    again = start_router(tmp_path / "again.txt", served.port)
    try:
        end = time.monotonic() + 20.0
        while time.monotonic() < end and not served.session.info.routers_zid():
            time.sleep(0.1)
        follow(served, beam, 3.0)
        assert served.process.end() == 0
    finally:
        again.process.kill()
        again.process.wait()
    ticks = check_lost_and_found(served, beam)
    assert np.median([tick.lateness for tick in ticks]) < 2e-3


@pytest.mark.long
@pytest.mark.parametrize(
    ("words", "code"),
    [(("serve",), 0), (("plant",), 0), (("stream", "line", "--robot"), 0), (("alive",), 130)],
)
def test_ctrl_c_ends_the_wait_for_a_router(
    words: tuple[str, ...], code: int, beam_file: Path, tmp_path: Path, run: Start
) -> None:
    """Zenoh hears no signals while it waits; its configuration may tell it to wait for good."""
    settings = {"mode": "client", "scouting": {"multicast": {"enabled": False}}}
    where = {"endpoints": [f"tcp/127.0.0.1:{free_ports()}"], "timeout_ms": -1}
    config = tmp_path / "client.json5"
    config.write_text(json.dumps({**settings, "connect": where}))
    process = run(*words, beam_file, "--zenoh-config", config)
    end = time.monotonic() + START
    while "waiting for a router or peer that" not in process.output.read_text():
        assert process.process.poll() is None and time.monotonic() < end
        time.sleep(0.05)
    assert process.end() == code


@pytest.mark.slow
def test_of_two_nodes_that_claim_a_robot_one_serves(
    routed: tuple[Served, Process, Path], beam_file: Path, tmp_path: Path, run: Start
) -> None:
    served, _, config = routed
    late = run("serve", beam_file, "--zenoh-config", config)
    assert late.process.wait(START) == 2
    assert "another node serves 'beam' already: stop it first" in late.output.read_text()
    assert served.process.process.poll() is None
    assert served.process.end() == 0
    # and of two that start at the same time
    pair = [run("serve", beam_file, "--zenoh-config", config) for _ in range(2)]
    end = time.monotonic() + START
    while all(one.process.poll() is None for one in pair):
        assert time.monotonic() < end
        time.sleep(0.1)
    time.sleep(2.0)
    codes = [one.process.poll() for one in pair]
    assert sorted(codes, key=str) == [2, None]


@pytest.mark.slow
@pytest.mark.parametrize("broken", [Wire.SILENT, Wire.CUT])
def test_a_network_that_is_cut_holds_until_it_is_back(
    served: Served, beam: Robot, tmp_path: Path, broken: Wire
) -> None:
    port = free_ports()
    proxy = Proxy(port, served.port)
    session = zenoh.open(read_config(client_config(tmp_path / "client.json5", port)))
    far = Served(served.process, session, KEYS, port, served.log)
    try:
        follow(far, beam, 1.0)
        proxy.state = broken
        follow(far, beam, 1.5)
        proxy.state = Wire.WHOLE
        follow(far, beam, 4.0)
        assert served.process.end() == 0
    finally:
        close_session(session)
        proxy.close()
    check_lost_and_found(served, beam)
