"""`python -m benchmarks`: runs from the root of a clone, and refuses as `tauten` does."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from support.processes import run_benchmark

ROOT = Path(__file__).resolve().parents[2]


def test_it_runs_from_the_root_of_a_clone() -> None:
    command = [sys.executable, "-m", "benchmarks", "--help"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert all(name in done.stdout for name in ("qpcc", "contact-basis", "gallery", "manipulator"))


def test_an_error_of_the_set_up_is_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "robot.toml"
    page.write_text("nothing = 1", encoding="utf-8")
    assert run_benchmark("contact-basis", page) == 2
    message = capsys.readouterr().err
    assert message.startswith("tauten: ")
    assert "robot.toml" in message
    assert "Traceback" not in message
