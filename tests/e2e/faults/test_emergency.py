"""A stop gets through: without a model to import, and past connections that say nothing."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from contextlib import ExitStack

import pytest
import typer
import zenoh
from support.nodes import wait_mode
from support.processes import Served

from tauten.service.cli.app import app
from tauten.service.cli.emergency import emergency
from tauten.service.link import Mode, Network, NetworkError, OperatorCommand, send_command
from tauten.service.link import commanding as link_commanding
from tauten.service.plant import free_ports

HEAVY = ("numpy", "scipy", "numba", "rosbags", "rich", "prometheus_client", "daqp")
LOADED = """
import sys
sys.argv = ["tauten", "command", "beam"]
from tauten.service.cli import main
try:
    main()
except SystemExit as ended:
    assert ended.code == 2
print(*sorted({name.split(".")[0] for name in sys.modules}), *sys.modules)
"""


def test_an_emergency_command_imports_nothing_of_the_model() -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOADED], capture_output=True, text=True, check=True
    )
    loaded = set(done.stdout.split())
    assert "zenoh" in loaded
    assert "tauten.service.link" in loaded
    # rich shows what is wrong with the arguments: it is not loaded for a command that is complete
    assert not loaded & (set(HEAVY) - {"rich"})
    assert not {name for name in loaded if name.startswith(("tauten.model", "tauten.service.wire"))}


def test_it_takes_what_the_whole_program_takes() -> None:
    alone, whole = (typer.main.get_command(one) for one in (emergency, app))
    shown = [
        [
            (p.name, p.opts, p.required, p.envvar, p.help, p.min)
            for p in one.commands["command"].params
        ]  # type: ignore[attr-defined]
        for one in (alone, whole)
    ]
    assert shown[0] == shown[1]
    assert len(shown[0]) >= 4
    assert [p.name for p in alone.params][:2] == [p.name for p in whole.params][:2]


def test_a_stop_gets_past_silent_connections(served: Served) -> None:
    """Whoever can connect can open connections and say nothing; an operator comes in all the same."""
    with ExitStack() as silent:
        for _ in range(300):
            connection = socket.create_connection(("127.0.0.1", served.port), timeout=5.0)
            silent.enter_context(connection)
        answer = send_command("beam", Network(served.port), OperatorCommand.STOP)
        assert answer.mode is Mode.STOP
    wait_mode(served, Mode.STOP)


def test_a_node_that_does_not_answer_is_not_denied(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link_commanding, "_PATIENCE", 0.1)
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", free_ports()))
        listening.listen()
        port = listening.getsockname()[1]
        with pytest.raises(NetworkError, match=f"something listens on its port {port}"):
            send_command("beam", Network(port), OperatorCommand.STOP)
    with pytest.raises(NetworkError, match="no node serves 'beam'"):
        send_command("beam", Network(free_ports()), OperatorCommand.STOP)


def seconds_to_message(served: Served) -> float:
    """Time from the start of `tauten command beam stop` to its message."""
    heard = served.session.declare_subscriber(served.keys.command, zenoh.handlers.FifoChannel(4))
    command = [sys.executable, "-m", "tauten.service", "command", "beam", "stop"]
    begin = time.monotonic()
    with subprocess.Popen([*command, "--port", str(served.port)]) as process:
        assert b"stop" in bytes(heard.recv().payload)
        seconds = time.monotonic() - begin
    assert process.returncode == 0
    heard.undeclare()  # type: ignore[no-untyped-call]
    return seconds


def test_the_command_line_stops_a_node(served: Served) -> None:
    seconds_to_message(served)
    wait_mode(served, Mode.STOP)


@pytest.mark.realtime
def test_a_stop_leaves_half_a_second_after_enter(served: Served) -> None:
    assert sorted(seconds_to_message(served) for _ in range(5))[2] <= 0.5
