"""Commands in folders that cannot be written: one sentence at once, exit code 2, nothing half-written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import meshio
import pytest
from support.processes import run_main
from support.robots.bodies import box_mesh

from tauten.model.mesh import boundary_triangles

COMMANDS = (
    ("demo", "ROBOT", "--seconds", "1"),
    ("demo", "ROBOT", "--seconds", "1", "--out", "SEALED/run"),
    ("serve", "ROBOT", "--record", "SEALED/log.mcap"),
    ("new", "bar", "--mesh", "PART"),
    ("new", "bar", "--mesh", "PART", "--folder", "SEALED/bar"),
    ("reduce", "ROBOT", "--snapshots", "OPEN/snapshots", "--out", "SEALED/beam.basis"),
    ("reduce", "ROBOT", "--out", "OPEN/beam.basis"),
    ("reduce", "ROBOT", "--snapshots", "OPEN/snapshots", "--out", "OPEN/b.basis", "--curve", "SEALED/c.png"),
    ("check", "ROBOT", "--json", "SEALED/check.json"),
    ("check", "ROBOT", "--markdown", "PAGE"),
    ("check", "ROBOT", "--figure", "SEALED/check.png"),
    ("check", "ROBOT", "--regions", "SEALED/regions.png"),
    ("compare", "ROBOT"),
    ("bench", "closed-loop", "ROBOT", "--json", "SEALED/loop.json"),
)  # fmt: skip


@pytest.fixture
def sealed(tmp_path: Path) -> Iterator[Path]:
    """A folder that nobody can write to; to root, only one of the kernel's is."""
    folder = tmp_path / "sealed"
    folder.mkdir()
    (folder / "page.md").touch()
    folder.chmod(0o555)
    if os.geteuid() == 0:
        folder = Path("/sys/kernel")
        if not folder.is_dir():
            pytest.skip("root may write everywhere")
    yield folder
    (tmp_path / "sealed").chmod(0o755)


@pytest.fixture
def part(tmp_path: Path) -> Path:
    """A bar as a surface."""
    mesh = box_mesh((12.0, 12.0, 60.0), (2, 2, 8))
    file = tmp_path / "bar.stl"
    cells = [("triangle", boundary_triangles(mesh.tets))]
    meshio.write(file, meshio.Mesh(mesh.nodes, cells), binary=True)
    return file


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_a_folder_that_cannot_be_written_is_named_before_any_work(
    command: tuple[str, ...], sealed: Path, part: Path, beam_file: Path, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    open_folder = tmp_path / "open"
    open_folder.mkdir()
    robot_folder = sorted(beam_file.parent.iterdir())
    there = sorted(path.name for path in sealed.iterdir())
    monkeypatch.chdir(sealed)
    page = next(path for path in sorted(sealed.iterdir()) if path.is_file())
    named = {"ROBOT": beam_file, "PART": part, "SEALED": sealed, "PAGE": page, "OPEN": open_folder}
    words = []
    for word in command:
        first, slash, rest = word.partition("/")
        words.append(f"{named.get(first, first)}{slash}{rest}")
    assert run_main(*words) == 2
    out, err = capsys.readouterr()
    said = " ".join(err.replace("│", " ").split())
    assert "permitted" in said or "denied" in said
    assert "cannot be written" in said
    assert "Traceback" not in said and "Errno" not in said
    assert out == ""  # nothing was computed first
    assert sorted(path.name for path in sealed.iterdir()) == there
    assert sorted(beam_file.parent.iterdir()) == robot_folder
    assert list(open_folder.iterdir()) == []
