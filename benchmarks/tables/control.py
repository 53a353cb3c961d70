"""The numbers of `python -m benchmarks closed-loop` and `still` as tables."""

from __future__ import annotations

import numpy as np

from benchmarks.control import ContactLoops, Outcome, StillBench, StillRun
from tauten.service.tables import Numbers, Page, measured_on


def closed_loop_page(result: ContactLoops) -> Page:
    """Errors in open and closed loop, and the controllers' tensions and times."""
    pairs: dict[tuple[str, str], list[Outcome]] = {}
    for one in result.outcomes:
        plant = "" if one.young_scale == 1.0 else f" E x {one.young_scale:g}"
        pairs.setdefault((one.case + plant, one.contact), []).append(one)
    about = (
        f"{result.robot}, {result.seconds:g} s a case at {result.rate_hz:g} Hz. The plant takes "
        f"{result.plant_steps} steps a period, twice as many move it by {result.plant_error_percent:.2g} % "
        f"of its way. Error of the mesh: {result.mesh_error}. Times: {measured_on(result.machine)}"
    )
    tables = closed_loop_errors_table(pairs), closed_loop_costs_table(pairs)
    return Page(f"python -m benchmarks closed-loop {result.robot}", about, tables)


def closed_loop_errors_table(pairs: dict[tuple[str, str], list[Outcome]]) -> Numbers:
    """How far the robot is from its target."""
    rows = []
    for (case, contact), pair in pairs.items():
        settled = ("-" if one.settling_s is None else f"{one.settling_s:.2f}" for one in pair)
        rows.append(
            (
                case,
                contact,
                " / ".join(f"{one.rms_mm:.2f}" for one in pair),
                " / ".join(f"{one.end_mm:.2f}" for one in pair),
                " / ".join(settled),
                f"{100.0 * pair[0].touching:.0f} %",
            )
        )
    columns = ("case", "contact", "RMS [mm]", "at end [mm]", "settled [s]", "touching")
    title = "Full-order robot against its target, open / closed loop"
    return Numbers(title, columns, tuple(rows))


def closed_loop_costs_table(pairs: dict[tuple[str, str], list[Outcome]]) -> Numbers:
    """Tension, chatter and times, in closed loop."""
    rows = []
    for (case, contact), pair in pairs.items():
        one = pair[-1]
        rows.append(
            (
                case,
                contact,
                f"{one.effort_n:.2f}",
                f"{one.chatter_mm_s:.1f}",
                f"{one.latency_ms.p50:.2f} / {one.latency_ms.p99:.2f}",
                f"{one.misses} / {one.ticks}",
            )
        )
    columns = ("case", "contact", "tension [N]", "chatter [mm/s]", "latency [ms]", "missed")
    return Numbers("What it takes, closed loop", columns, tuple(rows))


def still_page(result: StillBench) -> Page:
    """Share of the runs at rest and at the best place, by robot, and random orders."""
    groups = dict.fromkeys(
        (run.robot, run.model, run.loop, run.contact) for run in result.runs
    )  # in order
    rows = []
    for robot, model, loop, contact in groups:
        runs = [
            run
            for run in result.runs
            if (run.robot, run.model, run.loop, run.contact) == (robot, model, loop, contact)
        ]
        best = [run for run in runs if run.best_mm is not None]
        rows.append(
            (
                robot, model, loop, "yes" if contact else "no", str(len(runs)),
                str(sum(run.rests for run in runs)),
                _median([run.rest_s for run in runs if run.rest_s is not None]),
                _median([run.own_rest_s for run in best if run.own_rest_s is not None]),
                str(sum(run.is_best for run in best)) if best else "–",
                str(sum(run.is_near for run in best)) if best else "–",
                _farther(best),
                f"{max(run.position for run in runs):.1e}", f"{max(run.effort for run in runs):.1e}",
            )
        )  # fmt: skip
    heads = (
        "robot", "model", "loop", "contact", "targets", "at rest", "seconds to rest, median",
        "of the robot alone", "within 1 % of the best place", "and 0.1 % of the way",
        "farther than it, at most [mm]", "largest change of a position", "of an effort",
    )  # fmt: skip
    tables = [Numbers("constant targets within twice the workspace", heads, tuple(rows), 4)]
    if result.orders:
        found = tuple(
            (
                item.robot, str(item.orders), str(item.unusable), str(item.stuck),
                f"{item.beyond:.1e}", f"{item.needed:.1e}",
            )
            for item in result.orders
        )  # fmt: skip
        title = "random locks, holds, unlocks and targets"
        columns = ("robot", "orders", "unusable", "stuck after", "left beyond", "needed beyond")
        tables.append(Numbers(title, columns, found))
    minutes, asked = result.settings.minutes, result.settings.targets
    about = (
        f"{asked} targets of each group, fewer where {minutes:g} minutes for a robot and its model were not "
        f"enough. Measured on {measured_on(result.machine)}"
    )
    full = " --model full" if result.settings.models == ("full",) else ""
    return Page(f"python -m benchmarks still{full}", about, tuple(tables))


def _farther(runs: list[StillRun]) -> str:
    """How much farther from the target than the best place a run ends, at most."""
    lengths = [run.error_mm - run.best_mm for run in runs if run.best_mm is not None]
    return f"{max(lengths):.3f}" if lengths else "–"


def _median(values: list[float]) -> str:
    return f"{float(np.median(values)):.2f}" if values else "–"
