"""A package of two kernel files and a program, which tests run in processes of its own."""

from __future__ import annotations

from pathlib import Path

from support.processes import Process, start_script

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


def start(folder: Path, cache: Path, output: str = "output.txt", **variables: str) -> Process:
    """A process that calls the outer kernel and prints its value, cache hits and cache misses."""
    main = folder / "main.py"
    given = {"NUMBA_CACHE_DIR": str(cache), "PYTHONDONTWRITEBYTECODE": "1", **variables}
    return start_script(folder / output, main, **given)


def end(process: Process) -> tuple[float, int, int]:
    """Value of the outer kernel, cache hits and cache misses."""
    assert process.process.wait(300.0) == 0, process.output.read_text()
    value, hits, misses = process.output.read_text().splitlines()[-1].split()
    return float(value), int(hits), int(misses)


def run(folder: Path, cache: Path, **variables: str) -> tuple[float, int, int]:
    """Value of the outer kernel, cache hits and cache misses, in a new process."""
    return end(start(folder, cache, **variables))
