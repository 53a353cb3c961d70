"""A stop gets through: without a model to import, and past connections that say nothing."""

from __future__ import annotations

import os
import re
import socket
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path

import pytest
import zenoh
from support.nodes import wait_mode
from support.processes import Served, tauten
from typer.testing import CliRunner

from tauten.service.cli import emergency
from tauten.service.cli.app import app
from tauten.service.cli.emergency import Order, order_in
from tauten.service.link import (
    Keys,
    Mode,
    Network,
    NetworkError,
    OperatorCommand,
    Role,
    close_session,
    open_session,
    send_command,
)
from tauten.service.link import commanding as link_commanding
from tauten.service.link import network as link_network
from tauten.service.link.network import loopback_config
from tauten.service.plant import free_ports

HEAVY = {"numpy", "scipy", "numba", "rosbags", "rich", "typer", "prometheus_client", "daqp"}
LOADED = """
import sys
from tauten.service.cli.emergency import order_in
from tauten.service.cli import entry
assert order_in(["beam", "stop"]) is not None
print(*sorted({name.split(".")[0] for name in sys.modules}), *sys.modules)
"""


def test_an_emergency_command_imports_nothing_of_the_model() -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOADED], capture_output=True, text=True, check=True
    )
    loaded = set(done.stdout.split())
    assert "zenoh" in loaded
    assert "tauten.service.link" in loaded
    assert not loaded & HEAVY
    assert not {name for name in loaded if name.startswith(("tauten.model", "tauten.service.wire"))}


@pytest.mark.parametrize(
    "line",
    [
        "beam stop",
        "beam hold --port 20000",
        "--port=20000 beam --zenoh-config=one.json5 enable",
        "--zenoh-config one.json5 beam reset --port 20001 --port 65534",
        "beam stop --port 1024",
        "beam stop --port 1023",
        "beam stop --port 65535",
        "beam stop --port ten",
        "beam stop --port",
        "beam stop --port --zenoh-config",
        "beam stop --zenoh-config=",
        "beam stop --por 20000",
        "beam stop -p",
        "beam stop --",
        "beam STOP",
        "beam halt",
        "beam stop now",
        "beam",
        "stop",
        "",
        "--help",
    ],
)
def test_it_reads_a_command_as_the_whole_program_does(
    line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    check_order(line, None, monkeypatch)


@pytest.mark.parametrize(
    "line",
    [
        "beam stop",
        "beam stop --port 20000",
        "beam hold --zenoh-config one.json5",
        "beam stop --zenoh-config=",
        "beam",
    ],
)
@pytest.mark.parametrize("variable", ["", "named.json5"])
def test_it_reads_the_variable_as_the_whole_program_does(
    line: str, variable: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    check_order(line, variable, monkeypatch)


def check_order(line: str, variable: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    """An order that is found is that of the whole program; where that ends, none is found."""
    sent: list[Order] = []
    monkeypatch.setattr(emergency, "carry_out", lambda order: sent.append(order) or "")
    monkeypatch.delenv("TAUTEN_ZENOH_CONFIG", raising=False)
    if variable is not None:
        monkeypatch.setenv("TAUTEN_ZENOH_CONFIG", variable)
    words = line.split()
    whole = CliRunner().invoke(app, ["command", *words])
    order = order_in(words)
    if whole.exit_code or not sent:
        assert order is None
    else:
        assert order in (None, *sent)
    if " ".join(words[:2]) in ("beam stop", "beam hold") and len(words) == 2:
        assert order is not None  # what is typed in a hurry


def test_a_robot_file_is_as_good_as_the_name_in_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who serves a file types the file again to stop it."""
    file = tmp_path / "my_arm.toml"
    file.write_text('name = "beam"\n')
    check_order(f"{file} stop", None, monkeypatch)
    order = order_in([str(file), "stop"])
    assert order is not None
    assert order.robot == "beam"
    for text in ("name = 3\n", "name =\n", ""):
        file.write_text(text)
        with pytest.raises(NetworkError, match=re.escape(str(file))):
            order_in([str(file), "stop"])
        with pytest.raises(NetworkError, match=re.escape(str(file))):
            CliRunner().invoke(app, ["alive", str(file)], catch_exceptions=False)


@pytest.mark.long
def test_a_stop_gets_past_silent_connections(served: Served) -> None:
    """Whoever can connect can open connections and say nothing; an operator comes in all the same."""
    with ExitStack() as silent:
        for _ in range(300):
            connection = socket.create_connection(("127.0.0.1", served.port), timeout=5.0)
            silent.enter_context(connection)
        answer = send_command("beam", Network(served.port), OperatorCommand.STOP)
        assert answer.mode is Mode.STOP
    wait_mode(served, Mode.STOP)


def hasty(first_port: int, role: Role) -> zenoh.Config:
    """A configuration whose session, when it is closed, does not wait ten seconds for who says nothing."""
    config = loopback_config(first_port, role)
    config.insert_json5("transport/unicast/open_timeout", "200")
    return config


def test_a_node_that_does_not_answer_is_not_denied(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link_commanding, "_PATIENCE", 0.1)
    monkeypatch.setattr(link_network, "loopback_config", hasty)
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", free_ports()))
        listening.listen()
        port = listening.getsockname()[1]
        with pytest.raises(NetworkError, match=f"something listens on its port {port}"):
            send_command("beam", Network(port), OperatorCommand.STOP)
    with pytest.raises(NetworkError, match="no node serves 'beam'"):
        send_command("beam", Network(free_ports()), OperatorCommand.STOP)


def test_a_session_that_is_not_closed_in_time_hides_no_sentence(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """On a machine that was busy, Zenoh's error of closing took the place of what was wrong."""

    class Late:
        """A session whose connections Zenoh does not close within its time."""

        def __init__(self, session: zenoh.Session) -> None:
            self.session, self.liveliness = session, session.liveliness

        def close(self) -> None:
            self.session.close()  # type: ignore[no-untyped-call]
            raise zenoh.ZError("close operation timed out!")

    def opened(network: Network, role: Role, robot: str, connected: bool = True) -> Late:
        return Late(open_session(network, role, robot, connected))

    monkeypatch.setattr(link_commanding, "_PATIENCE", 0.1)
    monkeypatch.setattr(link_network, "open_session", opened)
    with pytest.raises(NetworkError, match="no node serves 'beam'"):
        send_command("beam", Network(free_ports()), OperatorCommand.STOP)
    assert "a session was not closed in time" in caplog.text


def test_the_command_line_stops_a_node(served: Served) -> None:
    done = tauten("command", "beam", "stop", "--port", str(served.port))
    assert done.returncode == 0
    assert done.stdout.startswith("beam: stop")
    wait_mode(served, Mode.STOP)


def times_to_message() -> tuple[float, float]:
    """Wall and processor time of `tauten command beam stop` until its message is at the node [s].

    The session has what a node has for the command: its port, its liveliness token and its subscriber.
    """
    network, keys = Network(free_ports()), Keys("beam")
    session = open_session(network, Role.NODE, "beam", connected=False)
    try:
        heard = session.declare_subscriber(keys.command, zenoh.handlers.FifoChannel(4))
        token = session.liveliness().declare_token(keys.token)
        command = [sys.executable, "-m", "tauten.service", "command", "beam", "stop"]
        begin = time.monotonic()
        with subprocess.Popen([*command, "--port", str(network.port)]) as process:
            assert b"stop" in bytes(heard.recv().payload)
            seconds = time.monotonic() - begin
            fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
            process.kill()
        token.undeclare()  # type: ignore[no-untyped-call]
    finally:
        close_session(session)
    return seconds, (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@pytest.mark.realtime
def test_a_stop_leaves_half_a_second_after_enter() -> None:
    walls, processor = zip(*(times_to_message() for _ in range(5)), strict=True)
    print(f"wall {sorted(walls)}, processor {sorted(processor)}, load {os.getloadavg()[0]:.1f}")
    assert sorted(walls)[2] <= 0.5


def test_a_file_that_is_no_configuration_is_not_quoted_whole(tmp_path: Path) -> None:
    file = tmp_path / "deep.toml"
    file.write_text("a = " + 5000 * "[" + 5000 * "]")
    with pytest.raises(NetworkError, match="no Zenoh configuration") as refused:
        open_session(Network(config=file), Role.OTHER, "beam")
    assert len(str(refused.value)) < 500 + len(str(file))
