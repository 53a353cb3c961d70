"""`tauten` commands as processes, and a small robot for them: two cables, two effectors, one beam."""

from __future__ import annotations

import dataclasses
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np
import pytest
import zenoh

from support.robots.bodies import box_mesh
from tauten.service.cli import main
from tauten.service.wire import Keys, is_alive

ROBOT = """\
name = "beam"
frame = "beam_base"
gravity = [0.0, 0.0, 0.0]
mesh = { file = "beam.vtu" }
material = { young_modulus = 1e6, poisson_ratio = 0.3, density = 1000.0 }
fixed = [{ lower = [0.0, 0.0, 0.0], upper = [0.0, 0.02, 0.02] }]
integration = { rayleigh_stiffness = 0.02 }
controller = { rate = 50.0 }
service = { target_timeout = 0.3, release_time = 0.4 }

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
START = 120.0  # s; kernels may have to be compiled


def write_robot(folder: Path, text: str = ROBOT) -> Path:
    """The robot's file and mesh in a folder; returns the file."""
    mesh = box_mesh((0.1, 0.02, 0.02), (8, 2, 2))
    meshio.Mesh(mesh.nodes, {"tetra": np.asarray(mesh.tets)}).write(folder / "beam.vtu")
    file = folder / "beam.toml"
    file.write_text(text)
    return file


@dataclasses.dataclass
class Process:
    """A `tauten` command that runs."""

    process: subprocess.Popen[bytes]
    output: Path

    def end(self, number: int = signal.SIGINT) -> int:
        """Signal it, wait, return the exit code."""
        self.process.send_signal(number)
        return self.process.wait(30.0)


def start(output: Path, *arguments: object) -> Process:
    """Start a `tauten` command."""
    command = [sys.executable, "-m", "tauten.service", *(str(a) for a in arguments)]
    with output.open("wb") as sink:
        return Process(subprocess.Popen(command, stdout=sink, stderr=subprocess.STDOUT), output)


def wait_alive(session: zenoh.Session, token: str, process: Process) -> None:
    """Wait for a liveliness token."""
    end = time.monotonic() + START
    while not is_alive(session, token):
        assert process.process.poll() is None, process.output.read_text()
        assert time.monotonic() < end, "did not start"
        time.sleep(0.05)


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


def run_main(*arguments: object) -> int:
    """Run a command in this process, which starts no interpreter; returns its exit code."""
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as ended:
        patch.setattr(sys, "argv", ["tauten", *(str(argument) for argument in arguments)])
        main()
    code = ended.value.code
    return 0 if code is None else int(code)
