"""Ctrl-C at any moment of any command: it ends, in one sentence at most, and leaves nothing half-written."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import meshio
import numpy as np
import pytest
from support.processes import START
from support.robots.bodies import box_mesh

from tauten.model.mesh import boundary_triangles
from tauten.reduction import ContactBasis
from tauten.service.plant import free_ports

COMMANDS = (
    ("check", "ROBOT", "--json", "check.json"),
    ("reduce", "ROBOT", "--out", "beam.basis", "--workers", "2"),
    ("reduce", "finger", "--out", "finger.basis", "--workers", "2"),
    ("compare", "finger", "--json", "compare.json"),
    ("demo", "ROBOT", "--seconds", "2", "--out", "run"),
    ("serve", "ROBOT", "--record", "log.mcap", "--port", "PORT"),
    ("plant", "ROBOT", "--port", "PORT"),
    ("stream", "line", "--robot", "ROBOT", "--port", "PORT"),
    ("new", "bar", "--mesh", "PART", "--size", "1.2", "--yes"),
    ("view", "ROBOT", "--simulate", "--no-browser", "--web-port", "0"),
    ("bench", "closed-loop", "ROBOT", "--json", "loop.json"),
    ("doctor",),
    ("lock", "beam", "upper", "--position", "0.001", "--port", "PORT"),
)
EARLIEST, LATEST = 0.2, 6.0  # s; before the first, Python itself starts
# Where an interrupt meets Python code that a library in C runs, the process ends by the signal itself; shells
# call that 130 too.
CODES = (0, 1, 2, 130, -signal.SIGINT)
MOST_TIME = 60.0  # s until a command has ended, on a machine that is busy with something else


def alive(group: int) -> bool:
    """Whether a process of a group runs."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.fixture
def part(tmp_path: Path) -> Path:
    """A bar as a surface."""
    mesh = box_mesh((12.0, 12.0, 60.0), (2, 2, 8))
    file = tmp_path / "bar.stl"
    cells = [("triangle", boundary_triangles(mesh.tets))]
    meshio.write(file, meshio.Mesh(mesh.nodes, cells), binary=True)
    return file


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS, ids=lambda words: f"{words[0]} {words[-1]}")
def test_ctrl_c_at_any_moment(
    command: tuple[str, ...], beam_file: Path, part: Path, tmp_path: Path
) -> None:
    rng = np.random.default_rng(sum(map(ord, " ".join(command))))
    named = {"ROBOT": str(beam_file), "PART": str(part)}
    for number, delay in enumerate(np.exp(rng.uniform(np.log(EARLIEST), np.log(LATEST), 4))):
        folder = tmp_path / str(number)
        folder.mkdir()
        named["PORT"] = str(free_ports())
        words = [named.get(word, word) for word in command]
        output = tmp_path / f"{number}.txt"
        with output.open("wb") as sink:
            process = subprocess.Popen(
                [sys.executable, "-m", "tauten.service", *words],
                cwd=folder, stdin=subprocess.DEVNULL, stdout=sink, stderr=sink, start_new_session=True,
            )  # fmt: skip
        try:
            time.sleep(delay)
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGINT)  # as a terminal does
            code = process.wait(START)
            text = output.read_text()[-2000:]
            said = f"{' '.join(words)} after {delay:.2f} s: {text}"
            assert code in CODES, said
            assert "Traceback" not in said, said
            assert sum(line.startswith("tauten: ") for line in text.splitlines()) <= 1, said
            end = time.monotonic() + MOST_TIME
            while alive(process.pid):
                assert time.monotonic() < end, f"a process is left; {said}"
                time.sleep(0.05)
        finally:
            if alive(process.pid):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        for file in folder.rglob("*"):
            assert not file.name.startswith("."), f"{file} is half-written; {said}"
            if file.suffix == ".json":
                json.loads(file.read_text(encoding="utf-8"))
            if file.suffix == ".basis":
                ContactBasis.load(file)
