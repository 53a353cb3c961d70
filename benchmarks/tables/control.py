"""The numbers of `python -m benchmarks closed-loop` as tables."""

from __future__ import annotations

from benchmarks.control import ContactLoops, Outcome
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
