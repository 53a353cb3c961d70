"""Faults of processes, disk, clock and messages: real processes and Zenoh, checked by the recorded log."""

from __future__ import annotations

import os
import resource
import signal
import time
from pathlib import Path

import numpy as np
import pytest
import zenoh
from support.faults import start_jumping
from support.messages import encode_point
from support.nodes import (
    PERIOD,
    check_limits,
    follow,
    last_health,
    modes,
    ordered,
    point_at,
    recorded,
    send_until_followed,
    streaming,
    wait_health,
    wait_mode,
    whole,
)
from support.processes import Process, Served, Start, wait_alive

from tauten.model import Robot
from tauten.service.codec.messages import POINT
from tauten.service.link import close_session
from tauten.service.log import LogReader
from tauten.service.plant import free_ports
from tauten.service.replay import read_run, replay
from tauten.service.wire import (
    CDR,
    HEALTH,
    JOINTS,
    JSON,
    TEXT,
    TICK,
    Cause,
    Keys,
    Level,
    Mode,
    Network,
    Role,
    open_session,
)

KEYS = Keys("beam")
TARGET = KEYS.targets(("tip",))[0]


@pytest.mark.long
def test_random_bytes_on_every_key_move_nothing(
    served: Served, beam: Robot, beam_file: Path, run: Start
) -> None:
    plant = run("plant", beam_file, "--port", served.port)
    wait_alive(served.session, KEYS.plant_token, plant)
    names = beam.effector_names
    keys = [
        *(*KEYS.targets(names), *KEYS.measurements(names), *KEYS.effectors(names), KEYS.command),
        *(KEYS.actuation, KEYS.tick, KEYS.health, KEYS.plant_state, KEYS.plant_gap),
        *(KEYS.plant_health, *KEYS.plant_effectors(names), KEYS.description, KEYS.metrics),
    ]
    kinds = [CDR, JSON, *(f"{CDR};{kind}" for kind in (POINT, JOINTS, HEALTH, TEXT, TICK)), "x/y"]
    rng = np.random.default_rng(2)
    for _ in range(40):
        for key in keys:
            head = b"\x00\x01\x00\x00" if rng.random() < 0.5 else b""
            payload = head + rng.bytes(int(rng.integers(0, 300)))
            served.session.put(key, payload, encoding=kinds[rng.integers(len(kinds))])
        time.sleep(PERIOD)
    health = wait_health(served, lambda found: int(found["commands"].values["refused"]) >= 30)
    assert int(health["targets"].values["refused"]) >= 60
    assert health["targets"].values["accepted"] == "0"
    assert served.process.end() == 0
    assert plant.end() == 0
    ticks, joints, _ = recorded(served.log, beam)
    assert {tick.mode for tick in ticks} == {Mode.IDLE, Mode.STOP}
    assert {joint.position for joint in joints} == {(0.0, 0.0)}
    assert whole(ticks)
    # the plant obeyed none of it, and the log can be read with the rubbish in it
    run_ = read_run(served.log)
    assert np.abs(run_.plant.value - beam.effector(beam.rest())[0]).max() < 1e-4


@pytest.mark.long
def test_a_full_disk_ends_the_log_and_not_the_node(served: Served, beam: Robot) -> None:
    ticks = served.session.declare_subscriber(KEYS.tick, zenoh.handlers.RingChannel(1000))
    send_until_followed(served, beam, 0.005)
    pid = served.process.process.pid
    full = served.log.stat().st_size + 20_000
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (full, full))
    with streaming(served, point_at(beam, 0.005).xyz):
        log = wait_health(served, lambda found: found["log"].level is Level.ERROR)["log"]
    assert "File too large" in log.message
    assert int(log.values["dropped"]) > 0
    assert served.process.end() == 0
    received = 0
    while ticks.try_recv() is not None:
        received += 1
    kept = [m for m in LogReader(served.log).messages() if m.key == KEYS.tick]
    assert 10 < len(kept) < received
    assert served.log.stat().st_size <= full


@pytest.mark.slow
def test_killed_plants_streams_and_nodes_are_missed_and_found_again(
    beam: Robot, beam_file: Path, tmp_path: Path, run: Start
) -> None:
    port = free_ports()
    common = ("--port", port)
    logs = [tmp_path / "first.mcap", tmp_path / "second.mcap"]

    def node(log: Path) -> Process:
        return run("serve", beam_file, "--closed-loop", "--record", log, *common)

    def plant() -> Process:
        return run("plant", beam_file, "--measure", *common)

    def stream() -> Process:
        return run("stream", "line", "--robot", beam_file, "--size", "0.004", *common)

    session = open_session(Network(port), Role.OTHER, "beam")
    try:
        serving, simulating, streaming = node(logs[0]), plant(), stream()
        wait_alive(session, KEYS.token, serving)
        wait_alive(session, KEYS.plant_token, simulating)
        served = Served(serving, session, KEYS, port, logs[0])
        wait_mode(served, Mode.RUN)
        streaming.end(signal.SIGKILL)
        wait_mode(served, Mode.HOLD, Cause.NO_TARGET)
        streaming = stream()
        wait_mode(served, Mode.RUN)
        simulating.end(signal.SIGKILL)
        wait_mode(served, Mode.HOLD, Cause.UNMEASURED)
        plant()
        wait_mode(served, Mode.RUN)
        time.sleep(1.5)  # a killed node's log lacks the last moment
        serving.end(signal.SIGKILL)
        serving = node(logs[1])
        wait_alive(session, KEYS.token, serving)
        wait_mode(served, Mode.RUN)
        assert serving.end() == 0
    finally:
        close_session(session)
    first, joints, _ = recorded(logs[0], beam)
    assert whole(first)
    check_limits(joints, beam)
    seen = [item for item in modes(first) if item[0] is not Mode.IDLE]
    run_, lost = (Mode.RUN, Cause.NONE), (Mode.HOLD, Cause.NO_TARGET)
    unmeasured = (Mode.HOLD, Cause.UNMEASURED)
    known = ordered([item for item in seen if item in (run_, lost, unmeasured)])
    assert known[:5] == [run_, lost, run_, unmeasured, run_]
    assert not LogReader(logs[0]).complete
    second, joints, _ = recorded(logs[1], beam)
    assert whole(second)
    assert run_ in modes(second)
    check_limits(joints, beam)


@pytest.mark.realtime
def test_ten_thousand_targets_a_second_cost_no_tick(served: Served, beam: Robot) -> None:
    seconds, burst = 10.0, 100
    publisher = served.session.declare_publisher(
        TARGET, encoding=CDR, congestion_control=zenoh.CongestionControl.DROP
    )
    payloads = [encode_point(point_at(beam, z, stamp=0)) for z in np.linspace(-0.02, 0.02, burst)]
    before = memory(served.process)
    begin, sent = time.monotonic(), 0
    while (elapsed := time.monotonic() - begin) < seconds:
        for payload in payloads:
            publisher.put(payload)
        sent += burst
        time.sleep(max(sent / 10_000.0 - elapsed, 0.0))
    assert sent >= 0.95 * 10_000 * seconds
    assert memory(served.process) < before + 30.0
    health = last_health(served)["targets"].values
    assert served.process.end() == 0
    ticks, joints, _ = recorded(served.log, beam)
    assert whole(ticks)
    check_limits(joints, beam)
    # all that one tick looks at is the ring, once ahead of it and once when it is due
    assert int(health["accepted"]) <= 2 * 64 * len(ticks)
    following = [tick for tick in ticks if tick.mode is Mode.RUN]
    assert len(following) > 0.9 * seconds / PERIOD
    assert np.median([tick.lateness for tick in following]) < 2e-3


def memory(process: Process) -> float:
    """Resident memory [MB]."""
    pages = int(Path(f"/proc/{process.process.pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


@pytest.mark.slow
def test_a_clock_that_jumps_moves_nothing(beam: Robot, beam_file: Path, tmp_path: Path) -> None:
    port, log, jump = free_ports(), tmp_path / "log.mcap", tmp_path / "jump.txt"
    serving = ("serve", beam_file, "--port", port, "--record", log)
    node = start_jumping(tmp_path / "serve.txt", jump, *serving)
    session = open_session(Network(port), Role.OTHER, "beam")
    served = Served(node, session, KEYS, port, log)
    try:
        wait_alive(session, KEYS.token, node)
        last_health(served)
        for nanoseconds in (0, 3600 * 10**9, -3600 * 10**9, 0):
            (tmp_path / "new.txt").write_text(str(nanoseconds))
            (tmp_path / "new.txt").rename(jump)
            follow(served, beam, 1.0)
        assert node.end() == 0
    finally:
        close_session(session)
        node.process.kill()
        node.process.wait()
    ticks, joints, _ = recorded(log, beam)
    assert np.abs(np.diff([1e-9 * tick.stamp for tick in ticks])).max() > 3000.0  # it did jump
    assert whole(ticks)
    check_limits(joints, beam)
    assert [mode for mode, _ in modes(ticks)] == [Mode.IDLE, Mode.RUN, Mode.STOP]
    latency = np.array([tick.latency for tick in ticks])
    assert np.nanmax(latency) < 1.0  # a time that no clock agrees with is no latency
    again = replay(log, tolerance=0.0, recorded_paths=True)
    assert again.same, (again.fraction, again.worst_tick, again.statuses)


@pytest.mark.slow
def test_a_long_run_neither_grows_nor_slows(
    served: Served, beam: Robot, beam_file: Path, run: Start
) -> None:
    """TAUTEN_SOAK seconds, by default half an hour."""
    seconds = float(os.environ.get("TAUTEN_SOAK", "1800"))
    plant = run("plant", beam_file, "--port", served.port)
    endless = ("--robot", beam_file, "--size", "0.004", "--port", served.port)
    stream = run("stream", "line", *endless)
    wait_alive(served.session, KEYS.plant_token, plant)
    wait_mode(served, Mode.RUN)
    alone = os.getloadavg()[0] <= len(os.sched_getaffinity(0))
    time.sleep(0.25 * seconds)  # warm-up
    warm = memory(served.process)
    time.sleep(0.75 * seconds)
    alone = alone and os.getloadavg()[0] <= len(os.sched_getaffinity(0))
    assert memory(served.process) < 1.02 * warm
    assert stream.end() == 0
    assert plant.end() == 0
    assert served.process.end() == 0
    ticks, joints, _ = recorded(served.log, beam)
    assert whole(ticks)
    check_limits(joints, beam)
    following = [tick for tick in ticks if tick.mode is Mode.RUN]
    # the fastest tenth of the steps is what other programs on the machine did not disturb
    half = len(following) // 2
    first, second = (
        np.percentile([tick.step for tick in part], 10.0)
        for part in (following[:half], following[half:])
    )
    assert second < 1.1 * first
    if alone:
        late = np.array([tick.slack < 0.0 for tick in following])
        assert late.mean() < 0.01
        # a count of rare events is certain up to some of its roots
        before, after = late[:half].sum(), late[half:].sum()
        assert after <= before + 4.0 * np.sqrt(before + 1.0)
