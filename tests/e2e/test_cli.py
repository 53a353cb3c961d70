"""The command line: errors are one sentence and exit 2; replay's exit code is its verdict."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from support.processes import ROBOT, run_main, tauten, write_robot


def test_help_names_every_command() -> None:
    result = tauten("--help")
    assert result.returncode == 0
    commands = "serve plant stream demo replay command record metrics alive doctor"
    commands += " reduce inspect compare check new bench"
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
def test_errors_are_a_sentence(
    arguments: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_main("--log-level", "error", *arguments) == 2
    said = capsys.readouterr()
    assert said.out == ""
    lines = said.err.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("tauten: ")
    assert message in lines[0]


def test_a_bad_robot_file_names_file_and_field(tmp_path: Path) -> None:
    """As a process: exit code and stderr are the operating system's."""
    file = write_robot(tmp_path, ROBOT.replace("rate = 50.0", "rate = -1.0"))
    result = tauten("serve", file)
    assert result.stdout == ""
    assert result.returncode == 2
    assert result.stderr.startswith(f"tauten: {file}: controller.rate: ")


def test_a_log_that_cannot_be_made_is_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    robot = write_robot(tmp_path)
    log = tmp_path / "file" / "log.mcap"
    assert run_main("--log-level", "error", "serve", robot, "--record", log) == 2
    said = capsys.readouterr().err
    assert said.startswith("tauten: ")
    assert len(said.strip().splitlines()) == 1
