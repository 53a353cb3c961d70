"""The numbers of `tauten bench closed-loop` as a table, for the terminal and for the docs."""

from __future__ import annotations

from tauten.service.bench import ClosedLoopBench
from tauten.service.tables.numbers import Numbers, Page, measured_on


def closed_loop_page(result: ClosedLoopBench) -> Page:
    """How far model and plant are from a target that moves, and from each other."""
    about = (
        f"{result.robot} at {result.rate_hz:g} Hz. Plant: {result.plant} order with {result.plant_unknowns} "
        f"unknowns, model with {result.model_unknowns}. The plant takes {result.plant_steps} steps a period, "
        f"twice as many move it by {result.plant_error_percent:.2g} % of its way; it runs at "
        f"{result.plant_speed:.2g} times real time. Error of the mesh: {result.mesh_error}. "
        f"Times: {measured_on(result.machine)}"
    )
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
    tables = (Numbers(title, columns, tuple(rows)),) if rows else ()
    return Page(f"tauten bench closed-loop {result.robot}", about, tables)
