"""Signals end a node in order: cables released, log finished; a second one hurries, a set-up ends at once."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.nodes import (
    PERIOD,
    check_limits,
    follow,
    recorded,
    send_until_followed,
    wait_mode,
)
from support.processes import (
    ROBOT,
    Process,
    Served,
    Start,
    client_of,
    run_main,
    wait_alive,
    write_robot,
)

from tauten.model import Robot, load_robot
from tauten.service import plant
from tauten.service.link import close_session
from tauten.service.log import LogReader
from tauten.service.plant import TargetPath, free_ports
from tauten.service.process import StopFlag, stop_on_signals
from tauten.service.replay import replay
from tauten.service.wire import Keys, Mode

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
KEYS = Keys("beam")


@contextmanager
def handled(number: signal.Signals, handler: Any) -> Iterator[None]:
    """A handler for a part of a test, whatever nohup or a shell has set before."""
    before = signal.signal(number, handler)
    try:
        yield
    finally:
        signal.signal(number, before)


@pytest.mark.parametrize("number", ENDING)
def test_a_signal_raises_the_flag_and_handlers_are_restored(number: signal.Signals) -> None:
    with handled(number, signal.SIG_DFL):
        with stop_on_signals() as stop:
            assert not stop.requested
            signal.raise_signal(number)
            assert stop.requested
            assert not stop.urgent
        assert signal.getsignal(number) is signal.SIG_DFL


def test_nohup_is_respected() -> None:
    with handled(signal.SIGHUP, signal.SIG_IGN), stop_on_signals() as stop:
        signal.raise_signal(signal.SIGHUP)
        assert not stop.requested


def test_commands_in_the_background_of_a_script_hear_ctrl_c() -> None:
    """Their shell has SIGINT ignored, with which Python raises no KeyboardInterrupt."""
    with handled(signal.SIGINT, signal.SIG_IGN):
        assert run_main("--help") == 0
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)


def test_a_second_request_is_urgent_but_not_the_same_one_twice() -> None:
    now = [10.0]
    stop = StopFlag(lambda: now[0])
    stop.request()
    now[0] += 0.1  # to the process and to its group
    stop.request()
    assert not stop.urgent
    now[0] += 0.5
    stop.request()
    assert stop.urgent


def test_a_set_up_ends_at_once() -> None:
    reached = []
    with stop_on_signals() as stop:
        with stop.interruptible():
            reached.append("before")
            signal.raise_signal(signal.SIGTERM)
            reached.append("after")
        reached.append("loop")
    assert reached == ["before"]
    with stop_on_signals() as stop:
        signal.raise_signal(signal.SIGTERM)
        with stop.interruptible():
            reached.append("set-up")
    assert reached == ["before"]


@pytest.mark.long
def test_ctrl_c_ends_a_stream_that_computes_its_path(monkeypatch: pytest.MonkeyPatch) -> None:
    """A path within reach takes seconds, with a large model minutes, to the end of which it went on."""
    computed = []

    def path(*_: object) -> TargetPath:
        signal.raise_signal(signal.SIGINT)
        computed.append("path")
        return TargetPath(np.zeros(1), np.zeros((1, 3)), repeats=False)

    monkeypatch.setattr(plant, "receiver_path", path)
    assert run_main("stream", "reach", "--robot", "finger", "--port", str(free_ports())) == 0
    assert computed == []


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGQUIT])
def test_a_node_releases_the_cables_and_finishes_its_log(
    served: Served, beam: Robot, number: signal.Signals
) -> None:
    send_until_followed(served, beam, 0.005)
    assert served.process.end(number) == 0
    check_released(served.log, beam)


def check_released(log: Path, beam: Robot) -> None:
    """A whole log of a robot that was pulled, then released within the limits."""
    reader = LogReader(log)
    list(reader.messages())
    assert reader.complete
    ticks, joints, _ = recorded(log, beam)
    assert ticks[-1].mode is Mode.STOP
    check_limits(joints, beam)
    assert max(joint.position[1] for joint in joints) > 2e-4
    assert joints[-1].position == (0.0, 0.0)
    assert joints[-1].effort == (0.0, 0.0)


@pytest.fixture
def slow(tmp_path: Path, run: Start) -> Iterator[tuple[Served, Robot]]:
    """A node that takes a minute to release its cables."""
    file = write_robot(tmp_path, ROBOT.replace("release_time = 0.4", "release_time = 60.0"))
    port, log = free_ports(), tmp_path / "log.mcap"
    node = run("serve", file, "--port", port, "--record", log)
    session = client_of(node, port)
    try:
        wait_alive(session, KEYS.token, node)
        yield Served(node, session, KEYS, port, log), load_robot(file)
    finally:
        close_session(session)


@pytest.mark.long
def test_a_second_ctrl_c_releases_as_fast_as_the_rates_permit(slow: tuple[Served, Robot]) -> None:
    served, beam = slow
    send_until_followed(served, beam, 0.005)
    served.process.process.send_signal(signal.SIGINT)
    wait_mode(served, Mode.STOP)
    time.sleep(1.0)
    assert served.process.process.poll() is None
    assert served.process.end() == 0  # within half of the minute
    check_released(served.log, beam)
    ticks, joints, _ = recorded(served.log, beam)
    stopped = [
        joint.position for tick, joint in zip(ticks, joints, strict=True) if tick.mode is Mode.STOP
    ]
    steps = -np.diff(np.array(stopped), axis=0)
    # the slow ramp, then the steps of the rate
    assert steps[0].max() < 0.01 * 0.05 * PERIOD
    assert steps.max() > 0.1 * 0.05 * PERIOD
    assert len(stopped) < 10.0 / PERIOD
    assert replay(
        served.log, tolerance=1e-9, recorded_paths=True
    ).same  # the log says when it hurries


@pytest.mark.realtime
@pytest.mark.parametrize("seconds", [0.5, 8.0])
def test_sigterm_while_kernels_compile_ends_promptly(
    beam_file: Path, tmp_path: Path, seconds: float
) -> None:
    output = tmp_path / "serve.txt"
    command = [sys.executable, "-m", "tauten.service", "serve", str(beam_file)]
    command += ["--port", str(free_ports())]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    with output.open("wb") as sink:
        process = subprocess.Popen(command, stdout=sink, stderr=sink, env=environment)
    node = Process(process, output)
    try:
        while "getting ready" not in output.read_text():
            assert process.poll() is None, output.read_text()
            time.sleep(0.05)
        time.sleep(seconds)
        begin = time.monotonic()
        assert node.end(signal.SIGTERM) == 0
        assert time.monotonic() - begin < 5.0
        assert "Traceback" not in output.read_text()
    finally:
        process.kill()
        process.wait()


@pytest.mark.long
def test_after_a_pause_no_tick_follows_an_old_target(served: Served, beam: Robot) -> None:
    """SIGSTOP and SIGCONT: what has waited for the node meanwhile is old."""
    send_until_followed(served, beam, 0.005)
    paused = served.process.process
    paused.send_signal(signal.SIGSTOP)
    stopped = time.time_ns()
    follow(served, beam, 2.0)
    resumed = time.time_ns()
    paused.send_signal(signal.SIGCONT)
    send_until_followed(served, beam, 0.005)
    assert served.process.end() == 0
    ticks, joints, _ = recorded(served.log, beam)
    check_limits(joints, beam)
    following = [tick for tick in ticks if tick.status and tick.target_stamp]
    assert any(tick.stamp > resumed for tick in following)
    age = [1e-9 * (tick.stamp - tick.target_stamp) for tick in following if tick.stamp > resumed]
    # The timeout is 0.3 s, the rest is for a machine that is busy. The signal may interrupt one tick.
    assert sum(seconds > 1.0 for seconds in age) <= 1
    assert not any(stopped + 5e8 < tick.stamp < resumed for tick in ticks)
