"""The numbers of `python -m benchmarks friction-inverse` as tables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.friction import CUTS, DriftRun, InverseFrictionBench, InverseRun, PressedRun
from tauten.service.tables import Numbers, Page, measured_on

ENOUGH = 0.01  # excess


def friction_inverse_page(result: InverseFrictionBench) -> Page:
    """All tables."""
    steps = [run for run in result.runs if run.name.startswith("step")]
    cases = [run for run in result.runs if run.name.startswith("case")]
    groups = [
        (f"{n_a} efforts", [run for run in steps if run.n_a == n_a])
        for n_a in sorted({run.n_a for run in steps})
    ]
    columns = ("steps", "number", "within 1 %", "hold returned", "within 1 %, warm")
    shares = Numbers(
        "random steps: share within 1 % of the best known objective",
        columns,
        tuple(_share_row(name, runs) for name, runs in (*groups, ("all", steps))),
    )
    sizes = sorted({(run.contacts, run.rank) for run in steps})
    solves = Numbers(
        "linear systems, cold and warm, and time of a cold solution",
        (
            "contacts / rank",
            "median",
            "99 %",
            "warm, median",
            "warm, 99 %",
            "thread, median [ms]",
            "99 % [ms]",
            "clock, median [ms]",
            "99 % [ms]",
        ),
        tuple(
            _solves_row(
                f"{contacts} / {rank}",
                [r for r in steps if r.contacts == contacts and r.rank == rank],
            )
            for contacts, rank in sizes
        ),
    )
    physical = Numbers(
        "physical cases that start where hold has no gradient",
        ("case", "excess", "linear systems"),
        tuple(
            (
                run.name.removeprefix("case_").replace("_", " "),
                f"{max(run.excess, 0.0):.1e}",
                f"{run.solves}",
            )
            for run in cases
        ),
    )
    about = f"Measured on {measured_on(result.machine)}"
    return Page(
        "python -m benchmarks friction-inverse",
        about,
        (
            shares,
            solves,
            _drifts(result.drifts),
            _pressed(result.pressed),
            physical,
            _checks(result),
        ),
    )


def _share_row(name: str, runs: Sequence[InverseRun]) -> tuple[str, ...]:
    within = [run.excess <= ENOUGH for run in runs]
    warm = [run.warm[0] <= ENOUGH for run in runs]
    stayed = sum(run.stayed for run in runs)
    return (name, f"{len(runs)}", _percent(within), f"{stayed}", _percent(warm))


def _solves_row(name: str, runs: Sequence[InverseRun]) -> tuple[str, ...]:
    cold, warm = [run.solves for run in runs], [run.warm[1] for run in runs]
    times = [run.cpu_ms for run in runs], [run.ms for run in runs]
    counts = (f"{np.percentile(of, share):.0f}" for of in (cold, warm) for share in (50, 99))
    return (
        name,
        *counts,
        *(f"{np.percentile(of, share):.1f}" for of in times for share in (50, 99)),
    )


def _drifts(runs: Sequence[DriftRun]) -> Numbers:
    """Closed loops."""
    rows = tuple(
        (
            f"{run.n_a}",
            f"{run.contacts} / {run.rank}",
            f"{run.pushing:.1f}",
            " / ".join(f"{value:.0f}" for value in run.solves),
            " / ".join(f"{value:.2f}" for value in run.cpu_ms),
            " / ".join(f"{value:.2f}" for value in run.wall_ms),
            f"{run.error:.4f}",
        )
        for run in runs
    )
    columns = (
        "efforts", "contacts / rank", "pushing", "linear systems", "thread [ms]", "clock [ms]", "RMS error",
    )  # fmt: skip
    return Numbers(
        "600 warm steps, median / 99 % of a step; error of the target's RMS way", columns, rows
    )


def _pressed(runs: Sequence[PressedRun]) -> Numbers:
    """Whole control steps."""
    rows = tuple(
        (
            f"{run.model} ({run.n})",
            f"{run.in_range:.0f}",
            f"{100.0 * run.touching:.0f} %",
            *(f"{middle:.2f} / {end:.2f}" for middle, end in (*run.thread_ms, run.clock_ms)),
            f"{run.cut}",
        )
        for run in runs
    )
    columns = (
        "model (unknowns)", "candidates in range", "touches", "prepare [ms]", "decide [ms]",
        "advance [ms]", "all [ms]", "all, clock [ms]", "not OK",
    )  # fmt: skip
    return Numbers(
        "whole inverse steps of the finger on a plate, median / 99 % of the thread's time",
        columns,
        rows,
    )


def _checks(result: InverseFrictionBench) -> Numbers:
    """What holds for every answer, and where friction is next to none."""
    runs, difference = result.runs, np.array(result.frictionless)
    cuts = " and ".join(f"{cut}" for cut in CUTS)
    rows = (
        ("largest error of the natural map", f"{max(run.error for run in runs):.0e}"),
        ("largest excess over a limit", f"{max(run.violation for run in runs):.0e}"),
        (f"the same error, cut after {cuts} systems", f"{max(run.cut[0] for run in runs):.0e}"),
        (f"the same excess, cut after {cuts} systems", f"{max(run.cut[1] for run in runs):.0e}"),
        ("largest objective of a cut search, of hold's", f"{max(run.cut[2] for run in runs):.3f}"),
        (
            "steps without friction, as low as the QPCC within 1e-4 of hold",
            _percent(difference <= 1e-4),
        ),
        ("the same, lower by more than that", _percent(difference < -1e-4)),
    )
    return Numbers("every answer; friction of 1e-9", ("check", "value"), rows)


def _percent(flags: Sequence[bool] | np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> str:
    return f"{100.0 * float(np.mean(flags)):.0f} %"
