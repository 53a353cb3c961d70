"""Ctrl-C in the mesher ends `tauten new` and its child; nothing is left behind."""

from __future__ import annotations

import os
import time
from pathlib import Path

import meshio
import pytest
from support.processes import START, start
from support.robots.bodies import box_mesh

from tauten.model.mesh import boundary_triangles


def children(process: int) -> list[int]:
    """Processes that this one has started and that run."""
    threads = Path(f"/proc/{process}/task").glob("*/children")
    return [int(child) for one in threads for child in one.read_text().split()]


def runs(process: int) -> bool:
    """Whether a process exists and is no zombie."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.long
def test_ctrl_c_in_the_mesher_ends_the_command_and_its_child(tmp_path: Path) -> None:
    """Elements of 0.75 mm take netgen minutes."""
    pytest.importorskip("netgen", reason="tauten[mesh] is not installed")
    mesh = box_mesh((12.0, 12.0, 60.0), (2, 2, 8))
    part = tmp_path / "bar.stl"
    cells = [("triangle", boundary_triangles(mesh.tets))]
    meshio.write(part, meshio.Mesh(mesh.nodes, cells), binary=True)
    options = ("--mesh", part, "--size", 0.75, "--yes", "--folder", tmp_path / "bar")
    process = start(tmp_path / "said", "new", "bar", *options)
    end = time.monotonic() + START
    while not (found := children(process.process.pid)):
        assert process.process.poll() is None, process.output.read_text()
        assert time.monotonic() < end, "the mesher did not start"
        time.sleep(0.05)
    (mesher,) = found
    while os.getpgid(mesher) != mesher:  # a group of its own: nothing else is ended with it
        assert time.monotonic() < end, "the mesher has no group of its own"
        time.sleep(0.01)  # it makes one after it was started
    assert process.end() == 130
    assert "stopped: nothing is written" in process.output.read_text()
    assert not runs(mesher)
    assert not (tmp_path / "bar").exists()
