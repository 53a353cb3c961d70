"""The command line: errors are one sentence and exit 2; replay's exit code is its verdict."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from support.processes import ROBOT, tauten, write_robot


def test_help_names_every_command() -> None:
    result = tauten("--help")
    assert result.returncode == 0
    commands = "serve plant stream demo replay command record metrics alive doctor"
    commands += " reduce inspect compare bench"
    for command in commands.split():
        assert re.search(rf"\b{command}\b", result.stdout)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("serve", "nobody"), "no robot 'nobody'"),
        (("plant", "none.toml"), "none.toml: cannot be read"),
        (("stream", "square", "--robot", "finger"), "no path 'square'"),
        (("stream", "circle", "--effector", "toe"), "finger has no effector 'toe', it has tip"),
        (("replay", "none.mcap"), "none.mcap: cannot be read"),
        (("inspect", "none.basis"), "none.basis: "),
        (("reduce", "finger", "--design", "none.csv"), "none.csv"),
    ],
)
def test_errors_are_a_sentence(arguments: tuple[str, ...], message: str) -> None:
    result = tauten(*arguments)
    assert result.returncode == 2
    assert result.stdout == ""
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("tauten: ")
    assert message in lines[0]


def test_a_bad_robot_file_names_file_and_field(tmp_path: Path) -> None:
    file = write_robot(tmp_path, ROBOT.replace("rate = 50.0", "rate = -1.0"))
    result = tauten("serve", file)
    assert result.returncode == 2
    assert result.stderr.startswith(f"tauten: {file}: controller.rate: ")


def test_a_log_that_cannot_be_made_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    robot = write_robot(tmp_path)
    result = tauten("serve", robot, "--record", tmp_path / "file" / "log.mcap")
    assert result.returncode == 2
    assert result.stderr.startswith("tauten: ")
    assert len(result.stderr.strip().splitlines()) == 1
