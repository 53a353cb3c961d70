"""The numbers of `tauten bench closed-loop` as tables, for the terminal and for the docs."""

from __future__ import annotations

from tauten.service.bench import ClosedLoopBench, Outcome
from tauten.service.tables.numbers import Numbers, Page, measured_on


def closed_loop_page(result: ClosedLoopBench) -> Page:
    """Errors in open and closed loop, and the controllers' tensions and times."""
    pairs: dict[tuple[str, str], list[Outcome]] = {}
    for one in result.outcomes:
        plant = "" if one.young_scale == 1.0 else f" E x {one.young_scale:g}"
        pairs.setdefault((one.case + plant, one.contact), []).append(one)
    cases = (
        f"{result.robot} at {result.rate_hz:g} Hz. Plant: {result.plant} order with {result.plant_unknowns} "
        f"unknowns, model with {result.model_unknowns}. The plant takes {result.plant_steps} steps a period, "
        f"twice as many move it by {result.plant_error_percent:.2g} % of its way; it runs at "
        f"{result.plant_speed:.2g} times real time. Error of the mesh: {result.mesh_error}."
    )
    if result.outcomes:
        cases += f" {result.seconds:g} s a case."
    about = f"{cases} Times: {measured_on(result.machine)}"
    tables: list[Numbers] = []
    if result.following:
        tables.append(following_table(result))
    if pairs:
        tables += [closed_loop_errors_table(pairs), closed_loop_costs_table(pairs)]
    command = f"tauten bench closed-loop {result.robot}{' --cases' if pairs else ''}"
    return Page(command, about, tuple(tables))


def following_table(result: ClosedLoopBench) -> Numbers:
    """How far model and plant are from a target that moves, and from each other."""
    rows = []
    for one in result.following:
        sizes = (one.target, one.own, one.apart, one.time, one.reduction)
        shown = (f"{size.rms_mm:.3f} / {size.max_mm:.3f}" for size in sizes)
        times = f"{one.step_ms.p50:.2f} / {one.step_ms.p99:.2f}"
        rows.append((f"{one.period_s:g}", *shown, f"{one.roughness:.3g}", times))
    columns = (
        "period [s]", "plant from target", "model from target", "plant from model", "share of time",
        "share of reduction", "roughness [N, Pa]", "step [ms]",
    )  # fmt: skip
    title = "A path in reach once in a period, open loop: RMS / largest [mm]; step median / p99"
    return Numbers(title, columns, tuple(rows))


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
