"""`tauten bench qpcc`: how long QPCCs take and how good their solutions are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tauten.controller.qpcc import available_backends
from tauten.service.bench.qpcc.quality import Quality, generated, measure, recorded
from tauten.service.bench.qpcc.times import (
    CABLES,
    FASTEST_OF,
    MODES,
    SolveTimes,
    make_problems,
    time_solves,
)
from tauten.service.process import HostInfo, host_info, one_blas_thread

Progress = Callable[[float, str], None]
OTHERS = 2  # random robots of a size that QP libraries other than the default are timed on
TIMING = 0.6  # share of the work that times are


@dataclass(frozen=True, slots=True)
class QpccBench:
    """Everything `tauten bench qpcc` measures.

    Attributes:
        machine: it was measured on.
        times: by library, size and start.
        quality: by set of problems.
    """

    machine: HostInfo
    times: tuple[SolveTimes, ...]
    quality: tuple[Quality, ...]


def bench_qpcc(folder: Path | None, progress: Progress) -> QpccBench:
    """Times of random robots' problems, quality of generated and recorded ones.

    Args:
        folder: with recorded problems; None: without them.
        progress: called with the share of the work that has just been done, and what comes next.
    """
    with one_blas_thread():
        times = bench_times(progress)
        quality = bench_quality(folder, progress)
    return QpccBench(host_info(), times, quality)


def bench_times(progress: Progress) -> tuple[SolveTimes, ...]:
    """Times of all libraries, sizes and starts; the default library first."""
    default, *others = available_backends()
    sizes = [(n_a, k) for n_a in CABLES for k in MODES]
    share = TIMING / (len(sizes) * (1 + len(others)))
    times, few = [], []
    for n_a, k in sizes:
        asked = make_problems(n_a, k)
        few.append(make_problems(n_a, k, OTHERS))
        progress(share, f"{default}: {n_a} cables, {k} modes")
        times += [time_solves(asked, default, warm, FASTEST_OF) for warm in (False, True)]
    for solver in others:
        for asked in few:
            times += [time_solves(asked, solver, warm, fastest_of=2) for warm in (False, True)]
            progress(share, f"{solver}: {times[-1].n_a} cables, {times[-1].k} modes")
    return tuple(times)


def bench_quality(folder: Path | None, progress: Progress) -> tuple[Quality, ...]:
    """Quality of all sets."""
    sets = [*generated(), *(recorded(folder) if folder is not None else ())]
    share = (1.0 - TIMING) / sum(len(cases) for _, cases in sets)
    return tuple(measure(name, cases, partial(progress, share, name)) for name, cases in sets)
