"""Machine code on disk follows the sources: a package of two kernel files, run in processes of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

CALLEE = """
from typing import NamedTuple

from tauten.model.numerics import kernel

SHARE = 2.0


class Pair(NamedTuple):
    first: float
    second: float


@kernel
def inner(x: float) -> float:
    return 3.0 * x
"""
CALLER = """
from callee import SHARE, Pair, inner

from tauten.model.numerics import kernel


@kernel
def outer(pair: Pair) -> float:
    return SHARE * inner(pair.first)
"""
MAIN = """
from callee import Pair
from caller import outer

value = outer(Pair(first=1.0, second=100.0))
print(value, sum(outer.stats.cache_hits.values()), sum(outer.stats.cache_misses.values()))
"""


def write(folder: Path) -> None:
    """The package's files."""
    for name, text in (("callee", CALLEE), ("caller", CALLER), ("main", MAIN)):
        (folder / f"{name}.py").write_text(text)


def run(folder: Path) -> tuple[float, int, int]:
    """Value of the outer kernel, cache hits and cache misses, in a new process."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    found = subprocess.run(
        [sys.executable, "main.py"],
        cwd=folder, env=environment, capture_output=True, text=True, check=True, timeout=100,
    )  # fmt: skip
    value, hits, misses = found.stdout.split()
    return float(value), int(hits), int(misses)


def test_changed_callee_is_compiled_into_its_caller(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    write(tmp_path)
    assert run(tmp_path) == (6.0, 0, 1)
    assert run(tmp_path) == (6.0, 1, 0), "unchanged sources are not compiled again"
    files = {path.name for path in tmp_path.rglob("*.nb?")}
    text = CALLEE
    for old, new, value in (
        ("3.0 * x", "5.0 * x", 10.0),  # the called kernel
        ("SHARE = 2.0", "SHARE = 7.0", 35.0),  # an imported constant
        ("first: float\n    second: float", "second: float\n    first: float", 35.0),
    ):
        text = text.replace(old, new)
        (tmp_path / "callee.py").write_text(text)
        assert run(tmp_path) == (value, 0, 1), new
    assert run(tmp_path) == (35.0, 1, 0)
    assert {path.name for path in tmp_path.rglob("*.nb?")} == files, "old entries are overwritten"


def test_a_renamed_module_of_a_callee_is_compiled_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    write(tmp_path)
    assert run(tmp_path) == (6.0, 0, 1)
    for name in ("caller", "main"):
        file = tmp_path / f"{name}.py"
        file.write_text(file.read_text().replace("from callee", "from renamed"))
    os.utime(tmp_path / "caller.py")
    (tmp_path / "callee.py").rename(tmp_path / "renamed.py")
    assert run(tmp_path) == (6.0, 0, 1)


def test_processes_that_start_together_compile_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    write(tmp_path)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    command = [sys.executable, "main.py"]
    together = [
        subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True)
        for _ in range(3)
    ]
    misses = [int(process.communicate(timeout=100)[0].split()[2]) for process in together]
    assert sum(misses) == 1
