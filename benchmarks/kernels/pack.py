"""`python -m benchmarks pack-kernels`: run what users run first, and pack the kernels that it needed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from benchmarks.kernels.archive import gather, used_archive
from tauten.model.kernels import (
    OFF,
    SEED,
    kernel_folder,
    open_seed,
    portable_machine,
)
from tauten.model.load import robot_path
from tauten.reduction import atomic_write
from tauten.service.kernels import kernel_caches
from tauten.service.process import Progress

LARGEST = 5_000_000  # bytes; a file of this size is committed
# a reduction of few equilibria and modes
REDUCE = (
    "-m", "tauten.service", "reduce", "finger", "--design", "ramp", "--step", "4e-3", "--k", "3",
)  # fmt: skip
STATES = ("--states", "--state-modes", "8", "--accept-error")
START = "from benchmarks.kernels.workload import run_robot; run_robot({!r})"
ROBOTS = (
    "finger", "trunk", "diamond", "tripod", "pneumatic_finger", "accordion", "gripper", "manipulator",
)  # fmt: skip
PLATE = """
[[obstacles]]
name = "plate"
shape = "plane"
parameters = { point = [0.02, 0.0, 0.0], normal = [-1.0, 0.0, 0.0] }

[[obstacles]]
name = "ground"
shape = "height-field"

[obstacles.parameters]
corner = [-0.2, -0.2, -0.103]
spacing = [0.2, 0.2]
thickness = 0.05
heights = [[0.0, 0.0, 0.0], [0.0, 0.001, 0.0], [0.0, 0.0, 0.0]]

[[contacts]]
against = "plate"
points = 40
friction = 0.5

[[contacts]]
against = "ground"
points = 40
friction = 0.3
"""


class PackError(OSError):
    """Kernels cannot be packed; the message says what to change."""


@dataclass(frozen=True, slots=True)
class Packed:
    """What was packed: the file, its size [bytes], how many entries of how many kernels it has."""

    file: Path
    size: int
    entries: int


def pack_kernels(file: Path, report: Progress, everything: bool = False) -> Packed:
    """Run the programs whose kernels are shipped, and pack those.

    What is compiled already, here or in the file that is shipped now, is not compiled again.

    Args:
        file: to write.
        report: called with the share that is done.
        everything: whether all of that is packed too.

    Raises:
        PackError: a program failed, or this processor compiles for itself alone.
    """
    if portable_machine() is None:
        raise PackError(
            "kernels that are packed here would run on few processors: unset NUMBA_CPU_NAME, or take a "
            "computer whose processor has the instructions of x86-64-v3"
        )
    caches = kernel_caches()
    with tempfile.TemporaryDirectory(prefix="tauten-kernels-") as name:
        work = Path(name)
        folder = kernel_folder(work / "cache")
        gather(caches, kernel_folder(), open_seed(), folder, everything)
        variables = {"NUMBA_CACHE_DIR": str(work / "cache"), SEED: OFF}
        commands = workload(work)
        for what, command in commands.items():
            report(0.0, what)
            run(command, variables)
            report(1.0 / len(commands), what)
        archive, entries = used_archive(caches, folder, work / "packed")
    with atomic_write(file) as opened:
        opened.write(archive)
    return Packed(file, len(archive), entries)


def workload(work: Path) -> dict[str, list[str]]:
    """What is run, by what is said meanwhile: the demo, shipped robots, friction, a reduction."""
    demo = ["-m", "tauten.service", "demo", "--seconds", "2", "--out", str(work / "demo")]
    robots = {f"{name}: control steps and a plant": ["-c", START.format(name)] for name in ROBOTS}
    snapshots = (
        "--snapshots",
        str(work / "snapshots"),
    )  # the second reduction has those of the first
    kinds = {"energy": STATES, "greedy": ("--method", "greedy")}
    reductions = {
        f"tauten reduce: {kind}": [*REDUCE, *options, *snapshots, "--out", f"{work / kind}.basis"]
        for kind, options in kinds.items()
    }
    plate = {"finger with friction": ["-c", START.format(str(finger_on_plate(work)))]}
    return {"tauten demo": demo, **robots, **plate, **reductions}


def finger_on_plate(folder: Path) -> Path:
    """The shipped finger before a plate and over a ground, with friction; its robot file in a folder."""
    source = robot_path("finger")
    shutil.copy(source.with_suffix(".vtu"), folder)
    file = folder / "finger.toml"
    file.write_text(source.read_text(encoding="utf-8") + PLATE, encoding="utf-8")
    return file


def run(command: list[str], variables: Mapping[str, str]) -> str:
    """Run Python with these arguments and further variables; returns what it printed.

    Raises:
        PackError: it failed.
    """
    done = subprocess.run(
        [sys.executable, *command], env={**os.environ, **variables}, capture_output=True, text=True
    )
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines() or ["no output"]
        raise PackError(f"python {' '.join(command)} ended with {done.returncode}: {lines[-1]}")
    return done.stdout
