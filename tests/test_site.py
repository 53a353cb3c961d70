"""The documentation site: it builds without warnings, loads nothing from elsewhere, and its commands run."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TUTORIAL = ROOT / "docs" / "tutorials" / "own_robot.md"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built in a process of its own as the contributors' command does."""
    pytest.importorskip("sphinx", reason="tauten[docs] is not installed")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "docs", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder


def test_every_page_is_reached_from_the_first(site: Path) -> None:
    first = (site / "index.html").read_text(encoding="utf-8")
    for page in sorted((ROOT / "docs").rglob("*.md")):
        name = page.relative_to(ROOT / "docs").with_suffix(".html")
        if "_build" in name.parts or name.name == "index.html":
            continue
        assert f'href="{name.as_posix()}"' in first, name


def test_pages_load_nothing_from_elsewhere(site: Path) -> None:
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert not re.findall(r'(?:src|<link[^>]*href)="(?:https?:)?//[^"]*', text), page.name


def test_the_reference_has_every_table_and_command(site: Path) -> None:
    robot_file = (site / "reference" / "robot-file.html").read_text(encoding="utf-8")
    commands = (site / "reference" / "commands.html").read_text(encoding="utf-8")
    for field in ("max_outside", "young_modulus", "alarm_distance", "target_timeout", "basis"):
        assert field in robot_file
    for command in ("serve", "reduce", "check", "new", "bench closed-loop"):
        assert f"tauten {command}" in commands


def tutorial_commands() -> list[str]:
    """The commands of the tutorial that are marked to be run."""
    text = TUTORIAL.read_text(encoding="utf-8")
    return re.findall(r"<!-- run -->\n```sh\n(.*?)\n```", text, flags=re.DOTALL)


@pytest.mark.slow
def test_the_commands_of_the_tutorial_run_as_written(tmp_path: Path) -> None:
    pytest.importorskip("netgen", reason="tauten[mesh] is not installed")
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    commands = tutorial_commands()
    assert len(commands) >= 3
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for command in commands:
        done = subprocess.run(
            shlex.split(command),
            cwd=tmp_path,
            env={**os.environ, "PATH": path},
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    assert (tmp_path / "bender" / "check.png").stat().st_size > 10_000
    assert (tmp_path / "bender" / "demo" / "run.mcap").exists()
