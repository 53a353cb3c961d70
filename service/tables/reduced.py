"""The numbers of `tauten bench reduced` as a table, for the terminal and for the docs."""

from __future__ import annotations

from tauten.service.bench import PathAccuracy, ReducedBench, ReducedCase
from tauten.service.tables.numbers import Numbers, Page, measured_on, milliseconds


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
