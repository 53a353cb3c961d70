"""Ports for the processes of a robot: two neighbours that no other process is given at the same time."""

from __future__ import annotations

import signal
import socket
import time
from contextlib import ExitStack
from pathlib import Path

import pytest
from support.processes import START, start_script

from tauten.service.plant import child, free_ports

RESERVE = """
import time
from tauten.service.plant import free_ports
print(free_ports(), flush=True)
time.sleep(300.0)
"""


def test_a_port_is_given_once() -> None:
    ports = [free_ports() for _ in range(50)]
    assert len({*ports, *(port + 1 for port in ports)}) == 100
    with ExitStack() as stack:
        for port in ports:
            for one in (port, port + 1):
                found = stack.enter_context(socket.socket())
                found.bind(("127.0.0.1", one))


def test_another_process_is_given_none_of_them(tmp_path: Path) -> None:
    (tmp_path / "reserve.py").write_text(RESERVE)
    first = start_script(tmp_path / "said.txt", tmp_path / "reserve.py")
    try:
        end = time.monotonic() + START
        while not first.output.read_text().endswith("\n") and time.monotonic() < end:
            time.sleep(0.02)
        taken = int(first.output.read_text())
        with socket.socket(socket.AF_UNIX) as held, pytest.raises(OSError, match="in use"):
            held.bind(f"\0tauten-{taken}")
        first.end(signal.SIGKILL)
        with socket.socket(socket.AF_UNIX) as again:  # the reservation ended with the process
            again.bind(f"\0tauten-{taken}")
    finally:
        first.end(signal.SIGKILL)


@pytest.mark.long
def test_processes_of_a_demo_are_on_loopback_whatever_network_the_user_has_chosen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their node and plant went to the router of a robot: that of the variable was used, not their port."""
    monkeypatch.setenv("TAUTEN_ZENOH_CONFIG", str(tmp_path / "none.json5"))
    with child("alive", ["beam", "--port", str(free_ports())], tmp_path) as asked:
        assert asked.process.wait(START) == 1
    assert asked.output.read_text() == "beam: not alive\n"
