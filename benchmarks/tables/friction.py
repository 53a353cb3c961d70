"""The numbers of `python -m benchmarks friction` as tables."""

from __future__ import annotations

from benchmarks.friction import FrictionBench
from tauten.service.tables import Numbers, Page, measured_on


def friction_page(result: FrictionBench) -> Page:
    """All tables."""
    rows = tuple(
        (
            one.name.replace("_", " "),
            f"{one.contacts}",
            f"{one.sticking} / {one.closed - one.sticking}",
            "yes" if one.indeterminate else "no",
            f"{one.newton} / {one.warm}",
            f"{one.error:.0e}",
            f"{one.siconos_error:.0e}",
            f"{one.sweeps_error:.0e}",
            f"{one.ms:.2f}",
            "–" if one.admm is None else f"{one.admm.iterations}",
            "–" if one.admm is None else f"{one.admm.error:.0e}",
            "–" if one.admm is None else f"{one.admm.ms:.2f}",
        )
        for one in result.runs
    )
    columns = (
        *("problem", "contacts", "stick / slip", "indeterminate", "Newton steps, cold / warm"),
        *("error", "Siconos' error", "Gauss-Seidel's error", "time [ms]"),
        *("ADMM's iterations", "ADMM's error", "ADMM's time [ms]"),
    )
    title = f"contact problems of others; Gauss-Seidel with up to {result.sweeps} sweeps"
    table = Numbers(title, columns, rows)
    return Page(
        "python -m benchmarks friction", f"Measured on {measured_on(result.machine)}", (table,)
    )
