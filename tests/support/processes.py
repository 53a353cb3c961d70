"""`tauten` commands as processes, and a small robot for them: two cables, two effectors, one beam."""

from __future__ import annotations

import atexit
import dataclasses
import fcntl
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path

import meshio
import numpy as np
import pytest
import typer.main
import zenoh

from benchmarks.commands import app
from support.robots.bodies import box_mesh
from tauten.service.cli import main, run
from tauten.service.wire import Keys, Network, Role, is_alive, open_session

# late_limit: at a load of ten a node misses most deadlines, and would never follow; the clock is asserted
# in tests that are marked `realtime`, and in those of the state machine
ROBOT = """\
name = "beam"
frame = "beam_base"
gravity = [0.0, 0.0, 0.0]
mesh = { file = "beam.vtu" }
material = { young_modulus = 1e6, poisson_ratio = 0.3, density = 1000.0 }
fixed = [{ lower = [0.0, 0.0, 0.0], upper = [0.0, 0.02, 0.02] }]
integration = { rayleigh_stiffness = 0.02 }
controller = { rate = 50.0 }
service = { target_timeout = 0.3, release_time = 0.4, late_limit = 100000 }

[[cables]]
name = "lower"
points = [[0.01, 0.01, 0.002], [0.1, 0.01, 0.002]]
max_tension = 30.0
max_pull = 0.02
max_rate = 0.05

[[cables]]
name = "upper"
points = [[0.01, 0.01, 0.018], [0.1, 0.01, 0.018]]
max_tension = 30.0
max_pull = 0.02
max_rate = 0.05

[[effectors]]
name = "tip"
point = [0.1, 0.01, 0.01]

[[effectors]]
name = "middle"
point = [0.05, 0.01, 0.01]
"""
START = 300.0  # s; kernels may have to be compiled, on a machine that is busy with something else


def write_robot(folder: Path, text: str = ROBOT) -> Path:
    """The robot's file and mesh in a folder; returns the file."""
    mesh = box_mesh((0.1, 0.02, 0.02), (8, 1, 1))
    meshio.Mesh(mesh.nodes, {"tetra": np.asarray(mesh.tets)}).write(folder / "beam.vtu")
    file = folder / "beam.toml"
    file.write_text(text)
    return file


class ForkServer:
    """The process that `tests/support/fork_server.py` describes, which all processes of the suite share."""

    def __init__(self) -> None:
        """Start it, unless another process of the suite has; it ends with the last of them."""
        run = os.environ.get("PYTEST_XDIST_TESTRUNUID", str(os.getpid()))
        address = Path(tempfile.gettempdir()) / f"tauten-{run}.socket"
        script = Path(__file__).with_name("fork_server.py")
        self._process: subprocess.Popen[bytes] | None = None
        self._socket = socket.socket(socket.AF_UNIX)
        with script.open() as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            try:
                self._socket.connect(str(address))
            except OSError:  # there is none, or it has ended
                self._start(script, address)
                self._socket.connect(str(address))
        self._file = self._socket.makefile("rw")
        self._lock = threading.Lock()
        atexit.register(self.close)

    def _start(self, script: Path, address: Path) -> None:
        """Start it and wait until it listens."""
        with tempfile.TemporaryDirectory() as folder:
            self._process = subprocess.Popen(
                [sys.executable, str(script), str(address), str(write_robot(Path(folder)))],
                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            )  # fmt: skip
            assert self._process.stdout is not None
            assert self._process.stdout.readline()

    def ask(self, **request: object) -> int | None:
        """The answer to a request."""
        with self._lock:
            self._file.write(json.dumps(request) + "\n")
            self._file.flush()
            answer: int | None = json.loads(self._file.readline())
        return answer

    def close(self) -> None:
        """Leave it, and wait for its end where this process has started it."""
        self._file.close()
        self._socket.close()
        if self._process is not None:
            with self._process:
                pass


@cache
def fork_server() -> ForkServer:
    """One for all tests of this process."""
    return ForkServer()


class Forked:
    """A process made by the fork server, with the part of `subprocess.Popen` that tests use."""

    def __init__(self, server: ForkServer, output: Path, **request: object) -> None:
        """Start what `tests/support/fork_server.py` is asked for: arguments of `tauten`, or a script."""
        output.write_bytes(b"")  # can be read from now on
        what = {"script": None, "folder": str(Path.cwd()), "environment": dict(os.environ)}
        pid = server.ask(output=str(output), **(what | request))
        assert pid is not None
        self.pid = pid
        self.returncode: int | None = None
        self._server = server

    def poll(self) -> int | None:
        """The exit code; None while it runs."""
        if self.returncode is None:
            self.returncode = self._server.ask(process=self.pid)
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its end; `subprocess.TimeoutExpired` where that takes more seconds."""
        end = None if timeout is None else time.monotonic() + timeout
        while (code := self.poll()) is None:
            if end is not None and time.monotonic() > end:
                raise subprocess.TimeoutExpired("tauten", timeout or 0.0)
            time.sleep(0.01)
        return code

    def send_signal(self, number: int) -> None:
        """Signal it unless it has ended."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """End it at once."""
        self.send_signal(signal.SIGKILL)


def forked(command: str, arguments: list[str], output: Path) -> Forked:
    """In place of `_start` and `Copy` of `tauten.service.plant.processes`, where a test runs a demo itself.

    An interpreter that starts takes seconds, and a process with Zenoh sessions must not be copied.
    """
    return Forked(fork_server(), output, arguments=[command, *arguments])


@dataclasses.dataclass
class Process:
    """A `tauten` command that runs."""

    process: subprocess.Popen[bytes] | Forked
    output: Path

    def end(self, number: int = signal.SIGINT) -> int:
        """Signal it, wait, return the exit code."""
        self.process.send_signal(number)
        return self.process.wait(START)


def start(output: Path, *arguments: object) -> Process:
    """Start a `tauten` command."""
    return Process(Forked(fork_server(), output, arguments=[str(a) for a in arguments]), output)


def start_script(output: Path, script: Path, **environment: str) -> Process:
    """Start a Python script, in its folder, where tauten is imported already.

    Args:
        output: file for what it prints.
        script: its file; modules beside it can be imported.
        environment: variables that are added.
    """
    request = {"folder": str(script.parent), "environment": {**os.environ, **environment}}
    return Process(Forked(fork_server(), output, script=str(script), **request), output)


def client_of(node: Process, port: int, robot: str = "beam") -> zenoh.Session:
    """A session of a client, opened once the node serves: one that finds no node looks again seldom."""
    end = time.monotonic() + START
    while ": serving " not in node.output.read_text():
        assert node.process.poll() is None, node.output.read_text()
        assert time.monotonic() < end, "did not start"
        time.sleep(0.02)
    return open_session(Network(port), Role.OTHER, robot, connected=False)


def wait_alive(session: zenoh.Session, token: str, process: Process) -> None:
    """Wait for a liveliness token."""
    end = time.monotonic() + START
    while not is_alive(session, token):
        assert process.process.poll() is None, process.output.read_text()
        assert time.monotonic() < end, "did not start"
        time.sleep(0.02)


Start = Callable[..., Process]


@dataclasses.dataclass
class Served:
    """A node, and a session of a client."""

    process: Process
    session: zenoh.Session
    keys: Keys
    port: int
    log: Path


def at_ordinary_priority(process: int) -> None:
    """Let the children of a process run as others do.

    A node's comparison with the full model takes only time that nothing else wants. On a busy machine
    there is none.

    Args:
        process: number of the process.
    """
    children = Path(f"/proc/{process}/task/{process}/children").read_text()
    for child in children.split():
        os.sched_setscheduler(int(child), os.SCHED_OTHER, os.sched_param(0))


def tauten(*arguments: object) -> subprocess.CompletedProcess[str]:
    """Run a command to its end."""
    command = [sys.executable, "-m", "tauten.service", "--log-level", "error"]
    command += [str(argument) for argument in arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120.0, check=False)


def blocks_interrupts(process: int | None) -> bool:
    """Whether Ctrl-C does not reach a process."""
    status = Path(f"/proc/{process}/status").read_text()
    blocked = next(line for line in status.splitlines() if line.startswith("SigBlk:"))
    return bool(int(blocked.split()[1], 16) >> (signal.SIGINT - 1) & 1)


def run_main(*arguments: object) -> int:
    """Run a command of `tauten` in this process, which starts no interpreter; returns its exit code."""
    return _run(main, arguments)


def run_benchmark(*arguments: object) -> int:
    """Run a command of `python -m benchmarks` in this process; returns its exit code."""
    return _run(lambda: run(app), arguments)


# each call of an app makes all of its commands anew, in 40 ms
_parser = cache(typer.main.get_command)


def _run(program: Callable[[], None], arguments: tuple[object, ...]) -> int:
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as ended:
        patch.setattr(sys, "argv", ["tauten", *(str(argument) for argument in arguments)])
        patch.setattr(typer.main, "get_command", _parser)
        program()
    code = ended.value.code
    return 0 if code is None else int(code)
