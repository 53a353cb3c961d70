"""`python -m benchmarks qpcc`: how long QPCCs take and how good their solutions are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path

from benchmarks.qpcc.quality import QpccCase, Quality, collections, generated, measure, recorded
from benchmarks.qpcc.times import (
    FASTEST_OF,
    LARGE,
    SIZES,
    Kind,
    Size,
    SolveTimes,
    make_problems,
    time_solves,
)
from tauten.controller.qpcc import available_backends
from tauten.model import one_blas_thread
from tauten.service.process import HostInfo, Progress, host_info

COMPARED = ((1, 5), (3, 10), (9, 23), (9, 40))  # cables and modes at which libraries are compared
ONE_START: tuple[Kind, ...] = ("descent", "warm")  # the homotopy is daqp's, whatever the library
KINDS: tuple[Kind, ...] = ("descent", "cold", "warm")
TIMING = 0.4  # share of the work that times are


@dataclass(frozen=True, slots=True)
class QpccBench:
    """Everything `python -m benchmarks qpcc` measures.

    Attributes:
        machine: it was measured on.
        times: by library, size and start.
        quality: by set of problems.
    """

    machine: HostInfo
    times: tuple[SolveTimes, ...]
    quality: tuple[Quality, ...]


def bench_qpcc(folder: Path, published: Path | None, progress: Progress) -> QpccBench:
    """Times of random robots' problems; quality of generated, recorded and published ones.

    Args:
        folder: with recorded problems.
        published: folder of problems that others wrote, with a problems.csv; None: without them.
        progress: called with the share of the work that has just been done, and what comes next.
    """
    with one_blas_thread():
        times = bench_times(progress)
        sets = [*generated(), *recorded(folder)]
        sets += collections(published) if published is not None else ()
        quality = bench_quality(sets, progress)
    return QpccBench(host_info(), times, quality)


def bench_times(progress: Progress) -> tuple[SolveTimes, ...]:
    """Times of the default library at all sizes, of the others at those that are compared."""
    default, *others = available_backends()
    share = TIMING / (len(SIZES) + len(others) * len(COMPARED))
    times: list[SolveTimes] = []
    for size in SIZES:
        progress(share, f"{default}: {size.n_a} cables, {size.k} modes")
        asked, fastest_of = make_problems(size), 1 if size.k >= LARGE else FASTEST_OF
        times += [time_solves(asked, default, kind, fastest_of) for kind in KINDS]
    for n_a, k in COMPARED:
        asked = make_problems(Size(n_a, k, robots=2))
        for solver in others:
            progress(share, f"{solver}: {n_a} cables, {k} modes")
            times += [time_solves(asked, solver, kind, fastest_of=2) for kind in ONE_START]
    return tuple(times)


def bench_quality(
    sets: list[tuple[str, list[QpccCase]]], progress: Progress
) -> tuple[Quality, ...]:
    """Quality of all sets."""
    share = (1.0 - TIMING) / sum(len(cases) for _, cases in sets)
    return tuple(measure(name, cases, partial(progress, share, name)) for name, cases in sets)
