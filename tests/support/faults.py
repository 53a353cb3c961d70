"""What goes wrong around a node, for tests to bring about: routers that die, wires that are cut, clocks
that jump."""

from __future__ import annotations

import json
import re
import selectors
import socket
import subprocess
import sys
import threading
import time
from enum import Enum
from pathlib import Path

from support.processes import Process

ROUTER_FILE = Path(__file__).parents[2] / "docker" / "zenoh" / "router.json5"
ROUTER = """\
import json, sys, time, zenoh
config = zenoh.Config()
for key, value in json.loads(sys.argv[1]).items():
    config.insert_json5(key, json.dumps(value))
session = zenoh.open(config)
print("open", flush=True)
while True:
    time.sleep(1.0)
"""
JUMPING = """\
import pathlib, sys, time
jump, real = pathlib.Path(sys.argv.pop(1)), time.time_ns
time.time_ns = lambda: real() + (int(jump.read_text() or 0) if jump.exists() else 0)
from tauten.service.cli import main
main()
"""


def start_router(output: Path, port: int) -> Process:
    """A Zenoh router as a process, on TCP, that waits for a client as the one in docker/zenoh does."""
    (wait,) = re.findall(r"wait_before_close: (\d+)", ROUTER_FILE.read_text(encoding="utf-8"))
    settings = {
        "transport/link/tx/queue/congestion_control/block/wait_before_close": int(wait),
        "mode": "router",
        "listen/endpoints": [f"tcp/127.0.0.1:{port}"],
        "scouting/multicast/enabled": False,
    }
    with output.open("wb") as sink:
        command = [sys.executable, "-c", ROUTER, json.dumps(settings)]
        process = Process(subprocess.Popen(command, stdout=sink, stderr=sink), output)
    while "open" not in output.read_text():
        assert process.process.poll() is None, output.read_text()
        time.sleep(0.02)
    return process


def start_jumping(output: Path, jump: Path, *arguments: object) -> Process:
    """A `tauten` command whose wall clock is off by a number of nanoseconds that is read from a file."""
    command = [sys.executable, "-c", JUMPING, str(jump), *(str(a) for a in arguments)]
    with output.open("wb") as sink:
        return Process(subprocess.Popen(command, stdout=sink, stderr=subprocess.STDOUT), output)


def client_config(file: Path, port: int) -> Path:
    """A Zenoh configuration of a client that finds its router again and again."""
    settings = {
        "mode": "client",
        "connect": {
            "endpoints": [f"tcp/127.0.0.1:{port}"],
            "timeout_ms": 10_000,
            "retry": {
                "period_init_ms": 100,
                "period_max_ms": 300,
                "period_increase_factor": 1.5,
            },
        },
        "scouting": {"multicast": {"enabled": False}},
    }
    file.write_text(json.dumps(settings))
    return file


class Wire(Enum):
    """What a wire does with what is put in."""

    WHOLE = 0
    SILENT = 1  # nothing passes, and no connection is closed
    CUT = 2  # connections break and cannot be made
    DEAF = 3  # the near end sends, and does not read what it is sent


class Proxy:
    """A wire between a port of its own and another, which a test cuts and mends."""

    def __init__(self, port: int, target: int) -> None:
        self.state = Wire.WHOLE
        self._target = target
        self._listener = socket.create_server(("127.0.0.1", port))
        self._open = True
        self._far: set[socket.socket] = set()  # connections to the target
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def close(self) -> None:
        self._open = False
        self._thread.join()

    def _run(self) -> None:
        with selectors.DefaultSelector() as selector, self._listener:
            selector.register(self._listener, selectors.EVENT_READ)
            while self._open:
                if self.state is Wire.SILENT:
                    time.sleep(0.02)
                    continue
                if self.state is Wire.CUT:
                    for key in [k for k in selector.get_map().values() if k.data is not None]:
                        self._drop(selector, key.fileobj)
                ready = [key for key, _ in selector.select(0.02)]
                if self.state is Wire.DEAF:
                    ready = [key for key in ready if key.fileobj not in self._far]
                    time.sleep(0.002)  # what is not read is ready at once
                for key in ready:
                    if key.fileobj.fileno() >= 0:
                        self._pass(selector, key)
            for key in [k for k in selector.get_map().values() if k.data is not None]:
                self._drop(selector, key.fileobj)

    def _pass(self, selector: selectors.BaseSelector, key: selectors.SelectorKey) -> None:
        if key.data is None:
            near, _ = self._listener.accept()
            try:
                if self.state is Wire.CUT:
                    raise ConnectionRefusedError
                far = socket.create_connection(("127.0.0.1", self._target))
            except ConnectionRefusedError:
                near.close()
                return
            self._far.add(far)
            selector.register(near, selectors.EVENT_READ, far)
            selector.register(far, selectors.EVENT_READ, near)
            return
        try:
            data = key.fileobj.recv(65_536)
            if data:
                key.data.sendall(data)
                return
        except OSError:
            pass
        self._drop(selector, key.fileobj)

    def _drop(self, selector: selectors.BaseSelector, one: socket.socket) -> None:
        if one.fileno() < 0:  # dropped with its other end already
            return
        other = selector.unregister(one).data
        selector.unregister(other)
        self._far -= {one, other}
        one.close()
        other.close()
