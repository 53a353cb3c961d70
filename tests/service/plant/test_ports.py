"""Ports for the processes of a robot: two neighbours that no other process is given at the same time."""

from __future__ import annotations

import socket
import subprocess
import sys
from contextlib import ExitStack

import pytest

from tauten.service.plant import free_ports

RESERVE = "from tauten.service.plant import free_ports; print(free_ports())"


def test_a_port_is_given_once() -> None:
    ports = [free_ports() for _ in range(50)]
    assert len({*ports, *(port + 1 for port in ports)}) == 100
    with ExitStack() as stack:
        for port in ports:
            for one in (port, port + 1):
                found = stack.enter_context(socket.socket())
                found.bind(("127.0.0.1", one))


def test_another_process_is_given_none_of_them() -> None:
    first = subprocess.Popen(
        [sys.executable, "-c", f"{RESERVE}; input()"], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert first.stdin is not None and first.stdout is not None
    try:
        taken = int(first.stdout.readline())
        with socket.socket(socket.AF_UNIX) as held, pytest.raises(OSError, match="in use"):
            held.bind(f"\0tauten-{taken}")
        first.communicate(b"\n", timeout=300.0)
        with socket.socket(socket.AF_UNIX) as again:  # the reservation ended with the process
            again.bind(f"\0tauten-{taken}")
    finally:
        first.kill()
        first.wait()
