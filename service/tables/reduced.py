"""The numbers of `tauten bench reduced` as tables, for the terminal and for the docs."""

from __future__ import annotations

from tauten.service.bench import STAGES, WHOLE, MeshCase, PathAccuracy, ReducedBench, ReducedCase
from tauten.service.replay import Spread
from tauten.service.tables.numbers import Numbers, Page, measured_on, milliseconds


def reduced_page(result: ReducedBench) -> Page:
    """All tables."""
    parts = cases_table(result), meshes_table(result.meshes), mesh_stages_table(result.meshes)
    return Page("tauten bench reduced", f"Measured on {measured_on(result.machine)}", parts)


def cases_table(result: ReducedBench) -> Numbers:
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
    return Numbers(title, columns, rows)


def case_row(case: ReducedCase) -> tuple[str, ...]:
    """One state basis."""
    unknowns = f"{case.modes} + {case.responses}" if case.responses else str(case.modes)
    return (
        unknowns, f"{case.sample:g}", str(case.elements), tip(case.training), depth(case.training),
        tip(case.foreign), depth(case.foreign), step(case.times.whole_ms["step"]),
    )  # fmt: skip


def meshes_table(meshes: tuple[MeshCase, ...]) -> Numbers:
    """The automatic choice by mesh."""
    fast = f"reduced, {meshes[0].fast_hz:g} Hz [ms]"
    columns = (
        "nodes", "tetrahedra", "candidates", "modes", "elements", "tip [mm]", "full [ms]",
        "reduced [ms]", fast,
    )  # fmt: skip
    rows = tuple(
        (
            str(mesh.sizes.nodes), str(mesh.sizes.elements), str(mesh.sizes.candidates),
            str(mesh.modes), str(mesh.elements), tip(mesh.training),
            *(step(times.whole_ms["step"]) for times in (mesh.full, mesh.reduced, mesh.fast)),
        )
        for mesh in meshes
    )  # fmt: skip
    return Numbers("Whole inverse steps, contacts active, median / 99 %", columns, rows)


def mesh_stages_table(meshes: tuple[MeshCase, ...]) -> Numbers:
    """Where the time of a step goes."""
    columns: list[str] = ["stage"]
    for mesh in meshes:
        nodes = f"{mesh.sizes.nodes} nodes"
        columns += [f"{nodes}, full", f"{nodes}, reduced", f"{nodes}, {mesh.fast_hz:g} Hz"]
    rows = []
    for stage in (*STAGES, *WHOLE):
        row = [stage]
        for mesh in meshes:
            for times in (mesh.full, mesh.reduced, mesh.fast):
                row.append(step({**times.stages_ms, **times.whole_ms}[stage]))
        rows.append(tuple(row))
    return Numbers("Stages of a step, median / 99 % in ms", tuple(columns), tuple(rows))


def tip(error: PathAccuracy) -> str:
    """Mean and largest distance of the tips, and how many equilibria were not found."""
    if error.mean_mm is None or error.max_mm is None:
        return "none found"
    lost = f", {error.lost} lost" if error.lost else ""
    return f"{error.mean_mm:.3f} / {error.max_mm:.3f}{lost}"


def depth(error: PathAccuracy) -> str:
    """Deepest penetration."""
    return f"{max(0.0, -error.deepest_gap_mm):.3f}"


def step(spread: Spread) -> str:
    """Median and 99th percentile, where there are any."""
    return "-" if spread.p50 is None else milliseconds(spread)
