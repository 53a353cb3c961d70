"""The numbers of `tauten bench` as tables, for the terminal and for the docs."""

from __future__ import annotations

from collections.abc import Sequence

from tauten.service.bench import (
    ClosedLoopBench,
    Deadlines,
    NodeBench,
    PathAccuracy,
    ReducedBench,
    ReducedCase,
    StepBench,
)
from tauten.service.tables.numbers import Numbers, Page, measured_on, milliseconds


def steps_page(result: StepBench) -> Page:
    """Forward and inverse steps without contact, on a mesh and its refinements."""
    rows = tuple(
        (
            str(mesh.sizes.nodes),
            str(mesh.sizes.elements),
            mesh.factorisation,
            milliseconds(mesh.forward_ms),
            milliseconds(mesh.inverse_ms),
        )
        for mesh in result.meshes
    )
    title = f"{result.robot}: one step without contact, median / p99 in ms"
    table = Numbers(title, ("nodes", "elements", "factorisation", "forward", "inverse"), rows, 0)
    return Page("tauten bench steps", f"Measured on {measured_on(result.machine)}", (table,))


def node_page(results: Sequence[NodeBench]) -> Page:
    """The node at each rate, and a loop that does nothing as long."""
    first = results[0]
    columns = (
        "loop", "ticks", "missed", "skipped", "decide", "step", "the rest", "begins late",
        "target to actuation", "processor",
    )  # fmt: skip
    title = f"{first.robot}, model {first.model}: median / 99 % in ms"
    table = Numbers(title, columns, tuple(row for result in results for row in node_rows(result)))
    about = (
        f"{first.seconds:g} s at each rate, {first.target_rate_hz:g} targets a second. "
        f"Measured on {measured_on(first.machine)}"
    )
    return Page("tauten bench node", about, (table,))


def node_rows(result: NodeBench) -> list[tuple[str, ...]]:
    """The node at one rate, its viewer where there was one, and the loop beside it."""
    spreads = (
        result.decide_ms,
        result.step_ms,
        result.overhead_ms,
        result.lateness_ms,
        result.latency_ms,
    )
    times = (milliseconds(spread) for spread in spreads)
    none = ("",) * len(spreads)
    name = f"node, {result.rate_hz:g} Hz"
    found = [(name, *counts(result.deadlines), *times, share(result.processor_share))]
    if result.surfaces_hz:
        viewer = f"viewer, {result.surfaces_hz:.0f} surfaces a second"
        found.append((viewer, "", "", "", *none, share(result.viewer_share)))
    return [*found, ("busy with nothing", *counts(result.idle), *none, "")]


def share(value: float) -> str:
    """A share in percent."""
    return f"{100.0 * value:.1f} %" if value == value else "-"


def counts(deadlines: Deadlines) -> tuple[str, str, str]:
    """Ticks, missed ones and their share, skipped ones."""
    missed = f"{deadlines.missed:,} ({100.0 * deadlines.share:.2f} %)"
    return f"{deadlines.ticks:,}", missed, f"{deadlines.skipped:,}"


def closed_loop_page(result: ClosedLoopBench) -> Page:
    """How far model and plant are from a target that moves, and from each other."""
    steps = "1 step" if result.plant_steps == 1 else f"{result.plant_steps} steps"
    about = (
        f"{result.robot} at {result.rate_hz:g} Hz. Plant: {result.plant} order with {result.plant_unknowns} "
        f"unknowns, model with {result.model_unknowns}. The plant takes {steps} a period, "
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


def reduced_page(result: ReducedBench) -> Page:
    """Modes and sample against errors and step time."""
    columns = (
        "modes + responses", "sample", "elements", "training path: tip [mm]", "deepest [mm]",
        "foreign loads: tip [mm]", "deepest [mm]", "step [ms]",
    )  # fmt: skip
    rows = tuple(case_row(case) for case in result.cases)
    title = (
        f"Tip error mean / max of {result.size_mm:.0f} mm, deepest penetration, control step median / "
        f"99 % at {result.rate_hz:g} Hz; {result.contact_modes} contact modes"
    )
    about = f"Measured on {measured_on(result.machine)}"
    return Page("tauten bench reduced", about, (Numbers(title, columns, rows),))


def case_row(case: ReducedCase) -> tuple[str, ...]:
    """One state basis."""
    unknowns = f"{case.modes} + {case.responses}" if case.responses else str(case.modes)
    return (
        unknowns, f"{case.sample:g}", str(case.elements), tip_distance(case.training), depth(case.training),
        tip_distance(case.foreign), depth(case.foreign), milliseconds(case.step_ms),
    )  # fmt: skip


def tip_distance(error: PathAccuracy) -> str:
    """Mean and largest distance of the tips, and how many equilibria were not found."""
    if error.mean_mm is None or error.max_mm is None:
        return "none found"
    lost = f", {error.lost} lost" if error.lost else ""
    return f"{error.mean_mm:.3f} / {error.max_mm:.3f}{lost}"


def depth(error: PathAccuracy) -> str:
    """Deepest penetration."""
    return f"{max(0.0, -error.deepest_gap_mm):.3f}"
