"""The numbers of `python -m benchmarks qpcc` as tables, for the terminal and for the docs."""

from __future__ import annotations

from collections.abc import Iterable

from benchmarks.qpcc import QpccBench, Quality, SolveTimes
from tauten.service.tables import Numbers, Page, measured_on, milliseconds


def qpcc_page(result: QpccBench) -> Page:
    """All tables."""
    default = result.times[0].solver
    parts = (
        sizes_table([one for one in result.times if one.solver == default], default),
        libraries_table(result.times),
        gaps_table(result.quality),
        residuals_table(result.quality),
    )
    return Page("python -m benchmarks qpcc", f"Measured on {measured_on(result.machine)}", parts)


def sizes_table(times: Iterable[SolveTimes], solver: str) -> Numbers:
    """Times and QPs of the default library by size."""
    rows: dict[tuple[int, int], list[str]] = {}
    starts: dict[str, None] = {}
    for one in times:
        starts[one.start] = None
        row = rows.setdefault((one.n_a, one.k), [f"{one.n_a} x {one.k}"])
        row += [milliseconds(one.ms), f"{one.pivots.p50:.0f} / {one.pivots.max:.0f}"]
    columns = [name for start in starts for name in (f"{start} [ms]", "QPs")]
    title = f"Time (median / 99 %) and QPs (median / most) with {solver}"
    return Numbers(title, ("cables x modes", *columns), tuple(map(tuple, rows.values())))


def libraries_table(times: tuple[SolveTimes, ...]) -> Numbers:
    """Times of all libraries at the sizes where they are compared, and how often they end OK."""
    rows: dict[str, dict[str, str]] = {}
    sizes = {(one.n_a, one.k) for one in times if one.solver != times[0].solver}
    for one in times:
        if (one.n_a, one.k) in sizes and one.start != "cold":
            ok = one.statuses.get("OK", 0) / one.problems
            column = f"{one.n_a} x {one.k} {one.start}"
            rows.setdefault(one.solver, {})[column] = f"{one.ms.p50:.2f}, {100.0 * ok:.0f} %"
    columns = list(dict.fromkeys(column for row in rows.values() for column in row))
    body = [(solver, *(row.get(column, "-") for column in columns)) for solver, row in rows.items()]
    title = "QP libraries: median in ms, share of problems that end OK"
    return Numbers(title, ("library", *columns), tuple(body))


def gaps_table(quality: Iterable[Quality]) -> Numbers:
    """How near the optimum solutions are."""
    rows = []
    for one in quality:
        for gaps in one.gaps:
            worst = "not solved" if gaps.worst is None else f"{100.0 * gaps.worst:.3g} %"
            problems = str(one.problems - one.empty)
            exact, percent = f"{100.0 * gaps.exact:.1f} %", f"{100.0 * gaps.percent:.1f} %"
            rows.append((one.name, gaps.start, problems, exact, percent, worst))
    columns = ("problems", "start", "number", "within 1e-6", "within 1 %", "worst")
    return Numbers("Objectives above the best known", columns, tuple(rows))


def residuals_table(quality: Iterable[Quality]) -> Numbers:
    """Certificates, and comparison with staying."""
    rows = []
    for one in quality:
        stay = f"{one.worse_than_staying} of {one.stay}" if one.stay else "-"
        numbers = (f"{one.residual:.1e}", f"{one.judged:.1e}", f"{100.0 * one.strong:.1f} %")
        rows.append((one.name, *numbers, stay, str(one.empty), str(one.unproved)))
    columns = ("problems", "own", "judged", "strong", "worse than staying", "empty", "open")
    return Numbers("Largest residuals, and what else was checked", columns, tuple(rows))
