"""What operators use: commands, metrics, doctor, priorities, rates that cannot be held, JSON lines."""

from __future__ import annotations

import json
import logging
import os
import re
import resource
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from pathlib import Path

import pytest
from prometheus_client.parser import text_string_to_metric_families
from support.messages import decoded_by_mcap
from support.nodes import send, send_until_followed
from support.processes import Served, run_main, start

from tauten.model import Robot
from tauten.service.bench import examine
from tauten.service.check import RateError, check_rate, fits, rate_for
from tauten.service.check.rate import faster
from tauten.service.cli.terminal.logs import JsonLines
from tauten.service.link import (
    Keys,
    OrderError,
    Role,
    ask_metrics,
    close_session,
    is_there,
    node_of,
    open_session,
    send_command,
)
from tauten.service.log import LogReader, record_robot
from tauten.service.node.statistics import BOUNDS, Histogram
from tauten.service.operate import serve_metrics
from tauten.service.plant import free_ports
from tauten.service.process import (
    RealtimeError,
    RealtimeSettings,
    StopFlag,
    apply_realtime,
)
from tauten.service.replay import read_run
from tauten.service.setup import load_setup
from tauten.service.wire import Cause, LockOrder, Mode, Network, NetworkError, OperatorCommand

NOBODY = 65_534


def fetched(url: str) -> str:
    """What a server that is about to start answers."""
    end = time.monotonic() + 60.0
    while True:
        try:
            with urllib.request.urlopen(url, timeout=5.0) as answer:
                return str(answer.read().decode())
        except urllib.error.URLError:
            assert time.monotonic() < end
            time.sleep(0.05)


@pytest.mark.long
def test_a_command_reaches_the_node_and_metrics_show_its_mode(served: Served, beam: Robot) -> None:
    send_until_followed(served, beam, 0.005)
    answer = send_command("beam", Network(served.port), OperatorCommand.HOLD)
    assert (answer.mode, answer.cause) == (Mode.HOLD, Cause.OPERATOR)
    assert is_there("beam", Network(served.port), served.keys.token)
    assert not is_there("beam", Network(served.port), served.keys.plant_token)
    stop, port = StopFlag(), free_ports()
    answering = (served.session, "beam", port, stop)
    server = threading.Thread(target=serve_metrics, args=answering)
    server.start()
    try:
        text = fetched(f"http://127.0.0.1:{port}/metrics")
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(f"http://127.0.0.1:{port}/secret", timeout=5.0)
        with pytest.raises(
            NetworkError,
            match=rf"port {port} on 127.0.0.1 cannot be opened \(Address .*: give another --http",
        ):
            serve_metrics(*answering)
        # browsers open connections on which they say nothing
        with (
            socket.create_connection(("127.0.0.1", port)),
            urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics?a=b", timeout=5.0) as answer,
        ):
            assert answer.status == 200
            stop.request()
            server.join(timeout=5.0)
            assert not server.is_alive()
    finally:
        stop.request()
        server.join()
    families = {family.name: family for family in text_string_to_metric_families(text)}
    accepted = families["tauten_targets_accepted"].samples[0]
    assert accepted.labels == {"robot": "beam"}
    assert accepted.value > 5
    assert families["tauten_commands_accepted"].samples[0].value == 1
    latency = families["tauten_latency_seconds"]
    assert latency.type == "histogram"
    buckets = [s.value for s in latency.samples if s.name.endswith("_bucket")]
    assert len(buckets) == len(BOUNDS) + 1
    assert buckets == sorted(buckets)
    assert buckets[-1] > 5
    assert "tauten_system_info" in text
    assert send_command("beam", Network(served.port), OperatorCommand.STOP).mode is Mode.STOP
    with pytest.raises(OrderError, match=r"beam: 'unlock .*' is not possible in a stop"):
        send_command("beam", Network(served.port), LockOrder(beam.actuators.names[0]))
    assert "refused the command 'unlock" in served.process.output.read_text()
    assert served.process.end() == 0
    assert ask_metrics(served.session, "beam") is None
    # commands come as JSON, and the profile of the log has CDR alone
    commands = [it.data for topic, _, it in decoded_by_mcap(served.log) if "command" in topic]
    assert commands[:2] == ["hold", "stop"]


def test_a_recorder_beside_the_node_records_the_run(
    served: Served, beam: Robot, tmp_path: Path
) -> None:
    log, stop, counts = tmp_path / "beside.mcap", StopFlag(), []

    def record() -> None:
        with node_of("beam", Network(served.port)) as session:
            counts.append(record_robot(session, "beam", log, stop))

    recorder = threading.Thread(target=record)
    recorder.start()
    while not log.exists():
        time.sleep(0.05)
    send_until_followed(served, beam, 0.005)
    send(served, beam, 0.005, 0.2, json=True)
    stop.request()
    recorder.join()
    run = read_run(log)
    assert run.description.model.digest == beam.digest
    assert run.complete
    assert run.following.sum() > 10
    assert len(run.model.time) > 10
    keys = {message.key for message in LogReader(log).messages()}
    assert {served.keys.tick, served.keys.actuation, "tauten/beam/target"} <= keys
    assert counts[0] > 30
    assert counts[0] == len(decoded_by_mcap(log))


def test_a_recorder_whose_disk_is_full_ends_with_the_reason(served: Served, tmp_path: Path) -> None:
    """What it has written remains."""
    log, (soft, hard) = tmp_path / "beside.mcap", resource.getrlimit(resource.RLIMIT_FSIZE)
    stop, errors = StopFlag(), []

    def record() -> None:
        with node_of("beam", Network(served.port)) as session:
            try:
                record_robot(session, "beam", log, stop)
            except OSError as error:
                errors.append(str(error))

    recorder = threading.Thread(target=record)
    recorder.start()
    try:
        while not log.exists() or log.stat().st_size == 0:
            time.sleep(0.05)
        resource.setrlimit(resource.RLIMIT_FSIZE, (log.stat().st_size, hard))
        stop.request()
        recorder.join()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert errors == [f"recording stopped: {log}: File too large"]
    assert log.stat().st_size > 0


@pytest.mark.slow
def test_a_recorder_waits_for_a_node_that_is_not_there_yet(tmp_path: Path) -> None:
    """Longer than other commands do, which ask where there is none after 5 s."""
    log, port = tmp_path / "beside.mcap", free_ports()
    recorder = start(tmp_path / "output.txt", "record", "beam", log, "--port", port)
    try:
        time.sleep(8.0)
        assert recorder.process.poll() is None
        assert "waiting for tauten/beam" in recorder.output.read_text()
        recorder.process.send_signal(signal.SIGINT)
        assert recorder.process.wait(10.0) == 130
    finally:
        recorder.process.kill()
    assert not log.exists()


@pytest.mark.long
def test_a_recorder_that_waits_for_a_node_ends_with_ctrl_c(tmp_path: Path) -> None:
    """A node that is getting ready is waited for, which takes minutes where kernels are compiled."""
    network, keys, log = Network(free_ports()), Keys("beam"), tmp_path / "beside.mcap"
    node = open_session(network, Role.NODE, "beam", connected=False)
    recorder = start(tmp_path / "output.txt", "record", "beam", log, "--port", network.port)
    try:
        token = node.liveliness().declare_token(keys.starting)
        end = time.monotonic() + 60.0
        while "waiting for tauten/beam" not in recorder.output.read_text():
            assert time.monotonic() < end
            time.sleep(0.02)
        recorder.process.send_signal(signal.SIGINT)
        assert recorder.process.wait(10.0) == 130
        token.undeclare()  # type: ignore[no-untyped-call]
    finally:
        recorder.process.kill()
        close_session(node)
    assert not log.exists()


def test_a_recorder_refuses_a_file_that_cannot_be_written_before_it_looks_for_a_node(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for file, why in (
        ("/proc/none/beside.mcap", "cannot be written"),
        (tmp_path, "is a directory"),
    ):
        assert run_main("record", "beam", file, "--port", NOBODY) == 2
        assert why in " ".join(capsys.readouterr().err.replace("│", "").split())


def test_a_command_without_a_node_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tauten.service.link.commanding._PATIENCE", 0.1)
    with pytest.raises(NetworkError, match=r"no node serves 'beam' on port \d+: start it"):
        send_command("beam", Network(free_ports()), OperatorCommand.STOP)


@pytest.mark.long
def test_a_command_waits_for_a_node_that_is_getting_ready(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels are compiled for minutes: nothing listened until then, and the command said that no node is."""
    monkeypatch.setattr("tauten.service.link.commanding._PATIENCE", 0.3)
    network, keys = Network(free_ports()), Keys("beam")
    node = open_session(network, Role.NODE, "beam", connected=False)
    try:
        tokens = [node.liveliness().declare_token(keys.starting)]
        begin = time.monotonic()

        def serve() -> None:
            tokens.append(node.liveliness().declare_token(keys.token))

        threading.Timer(1.2, serve).start()
        with node_of("beam", network):
            assert time.monotonic() - begin > 1.0
            assert len(tokens) == 2
    finally:
        close_session(node)


def test_a_histogram_counts_what_it_is_given() -> None:
    found = Histogram()
    for value in (5e-5, 1.5e-4, 1.5e-4, 3.0, float("nan")):
        found.add(value)
    assert found.text() == "0.1:1 0.2:2 more:1"
    assert found.cumulative()[:2] == [("0.0001", 1.0), ("0.0002", 3.0)]
    assert found.cumulative()[-1] == ("+Inf", 4.0)
    assert found.total == pytest.approx(3.00035)


def test_a_rate_the_computer_cannot_hold_is_refused_when_it_was_requested(
    caplog: pytest.LogCaptureFixture,
) -> None:
    advice = faster(Path("beam.toml"), 0.015, True, option=True)
    check_rate(50.0, 0.015, True, advice)
    with pytest.raises(RateError, match=r"100 Hz cannot be held.* 15.0 ms here; use --rate 53, or"):
        check_rate(100.0, 0.015, True, advice)
    check_rate(100.0, 0.015, False, advice)
    assert "100 Hz cannot be held" in caplog.text
    assert rate_for(0.015) == 53.0
    for seconds in (0.016, 0.0267, 0.000801, 0.8, 9.0):  # 0.0267 s: 29, not 30, which would not fit
        assert fits(rate_for(seconds), seconds)
        assert not fits(1.1 * rate_for(seconds), seconds)
    assert rate_for(0.016) == 50.0


def test_serve_refuses_such_a_rate(beam_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asking = ("serve", beam_file, "--rate", "9000", "--port", free_ports())
    assert run_main("--log-level", "error", *asking) == 2
    said = capsys.readouterr().err
    assert re.match(r"tauten: 9000 Hz cannot be held: a control step takes ", said)


def test_a_processor_that_is_not_there_is_refused() -> None:
    with pytest.raises(RealtimeError, match="no processor 4096 here"):
        apply_realtime(RealtimeSettings(cpus=(4096,)))


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give its rights up")
def test_priority_that_is_not_permitted_is_a_sentence(beam_file: Path, tmp_path: Path) -> None:
    code = (
        "import os; from tauten.service.process.realtime import *\n"
        f"os.setuid({NOBODY})\n"
        "try: apply_realtime(RealtimeSettings(priority=10))\n"
        "except RealtimeError as error: print(error)\n"
        "print(realtime_permitted())"
    )
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=300.0, check=True
    )
    assert "SCHED_FIFO at priority 10 is not permitted: run with the capability" in found.stdout
    assert found.stdout.endswith("False\n")


@pytest.mark.long
def test_the_loop_gets_its_priority_and_processor_where_permitted(
    beam_file: Path, tmp_path: Path
) -> None:
    cpu = min(os.sched_getaffinity(0))
    asking = ("serve", beam_file, "--port", free_ports(), "--priority", "5", "--cpus", cpu)
    node = start(tmp_path / "serve.txt", *asking)
    try:
        while "serving beam" not in node.output.read_text():
            if node.process.poll() is not None:
                pytest.skip(node.output.read_text().splitlines()[-1])
            time.sleep(0.05)
        assert os.sched_getscheduler(node.process.pid) == os.SCHED_FIFO
        assert os.sched_getaffinity(node.process.pid) == {cpu}
        assert node.end() == 0
    finally:
        node.process.kill()
        node.process.wait()


@pytest.mark.long
def test_the_doctor_measures_what_a_node_needs(beam_file: Path) -> None:
    found = {finding.what: finding for finding in examine(load_setup(beam_file), 1.0)}
    assert "in use" in found["factorisation"].found
    assert 0.0 < float(found["rate, requested / achieved"].found.split()[2]) < 51.0
    assert found["clock resolution"].found.endswith(" ns")
    assert "numpy" in found
    assert found["threads of BLAS and OpenMP"].advice == ""


def test_log_lines_are_json_on_request() -> None:
    try:
        raise ValueError("x")
    except ValueError:
        error = sys.exc_info()
    record = logging.LogRecord("tauten.x", logging.WARNING, "", 0, "%d °", (3,), error)
    found = json.loads(JsonLines().format(record))
    assert found["level"] == "warning"
    assert found["message"] == "3 °"
    assert found["time"].endswith("+00:00")
    assert "ValueError: x" in found["traceback"]
