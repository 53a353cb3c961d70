"""README's first command after pip: how long the demo takes, and how many kernels it compiles."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.kernels.pack import run
from tauten.model.kernels import OFF, SEED, kernel_folder
from tauten.service.plant import LOG
from tauten.service.process import HostInfo, Progress, host_info
from tauten.service.replay import read_run
from tauten.service.wire import Mode

COLD, SEEDED, WARM = "cold", "seeded", "warm"
SECONDS = 5.0  # of targets


@dataclass(frozen=True, slots=True)
class FirstHour:
    """One demo of 5 s of targets.

    Attributes:
        start: "cold", nothing is compiled; "seeded", shipped kernels are; "warm", it ran before. Python's
            bytecode counts as compiled code, of libraries too.
        seconds: from the command to its end.
        first_tick: from the command to the first target that the node followed [s].
        processor: time of all its processes together [s].
        compiled: entries of kernels that were compiled.
        machine: facts of the computer, with the load at the end.
    """

    start: str
    seconds: float
    first_tick: float
    processor: float
    compiled: int
    machine: HostInfo


def first_demos(
    report: Progress, starts: tuple[str, ...] = (COLD, SEEDED, WARM)
) -> list[FirstHour]:
    """Run the demo from each of these starts; a warm one uses what the one before has left.

    Raises:
        PackError: the demo failed.
    """
    found = []
    with tempfile.TemporaryDirectory(prefix="tauten-first-hour-") as name:
        work = Path(name)
        cache = work / "none"
        for number, start in enumerate(starts):
            report(0.0, f"demo, {start}")
            cache = cache if start == WARM else work / f"{number}"
            found.append(_demo(start, cache, work / f"demo-{number}"))
            report(1.0 / len(starts), f"demo, {start}")
    return found


def _demo(start: str, cache: Path, out: Path) -> FirstHour:
    variables = {
        "NUMBA_CACHE_DIR": str(cache),
        "PYTHONPYCACHEPREFIX": str(cache / "bytecode"),
        "PYTHONDONTWRITEBYTECODE": "",
    }
    if start == COLD:
        variables[SEED] = OFF
    before, used, begin = set(_compiled(cache)), _processor_time(), time.time()
    run(["-m", "tauten.service", "demo", "--seconds", f"{SECONDS:g}", "--out", str(out)], variables)
    seconds, used = time.time() - begin, _processor_time() - used
    compiled = len(set(_compiled(cache)) - before)
    return FirstHour(start, seconds, _first_tick(out) - begin, used, compiled, host_info())


def _processor_time() -> float:
    """Of the processes that this one started, and theirs, as far as they have ended [s]."""
    times = os.times()
    return times.children_user + times.children_system


def _compiled(cache: Path) -> Iterator[Path]:
    return kernel_folder(cache).glob("*.nbc")


def _first_tick(out: Path) -> float:
    """When the node of a demo first followed a target [s since 1970]; NaN where it never did."""
    stamps = [tick.stamp for tick in read_run(out / LOG).ticks if tick.mode is Mode.RUN]
    return 1e-9 * stamps[0] if stamps else float("nan")
