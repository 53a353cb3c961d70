"""The numbers of `python -m benchmarks elements` as tables, for the terminal and for the docs."""

from __future__ import annotations

from benchmarks.elements import ElementBench, ElementCase, ElementEquilibrium
from tauten.service.tables import Numbers, Page, measured_on, millimetres, percent

COLUMNS = (
    "element", "nodes", "nonzeros", "assembly [ms]", "step [ms]", "tension [N]", "tension", "tip [mm]",
    "contact force",
)  # fmt: skip


def element_page(result: ElementBench) -> Page:
    """A table for each material and pull, the reference in its last row."""
    tables = []
    for reference in result.references:
        cases = [case for case in result.cases if case.material == reference.material]
        for index, state in enumerate(reference.equilibria):
            rows = [element_row(case, case.equilibria[index]) for case in cases]
            rows.append(element_row(reference, state))
            title = f"{result.robot}, {reference.material}, {100.0 * state.position:g} % of the largest pull"
            tables.append(Numbers(title, COLUMNS, tuple(rows)))
    about = (
        f"Errors against the last row of each table. {result.factorisation}, one thread, medians. "
        f"Measured on {measured_on(result.machine)}"
    )
    return Page("python -m benchmarks elements", about, tuple(tables))


def element_row(case: ElementCase, state: ElementEquilibrium) -> tuple[str, ...]:
    """One mesh: medians of its times, and its errors."""
    found = ", ".join(f"{effort:.4f}" for effort in state.effort)
    errors = (
        percent(state.tension_error),
        millimetres(state.tip_error),
        percent(state.contact_error),
    )
    return (
        case.element,
        f"{case.nodes:,}",
        f"{case.nonzeros:,}",
        f"{case.assembly_ms.p50:.1f}",
        f"{case.step_ms.p50:.1f}",
        found if state.converged else "not found",
        *errors,
    )
