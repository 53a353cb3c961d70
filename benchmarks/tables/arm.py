"""The numbers of `python -m benchmarks manipulator` as tables, for the terminal and for the docs."""

from __future__ import annotations

from benchmarks.manipulator import ArmBench, PostureError, Speed
from benchmarks.steps import STAGES, WHOLE, StepTimes
from tauten.service.tables import Numbers, Page, measured_on, milliseconds


def arm_page(result: ArmBench) -> Page:
    """All tables and sentences."""
    gauss_seidel, contact = sentences(result)
    speed, stages = speed_table(result.speed), arm_stages_table(result.stages)
    parts = (speed, gauss_seidel, stages, contact, arm_errors_table(result))
    return Page(
        "python -m benchmarks manipulator", f"Measured on {measured_on(result.machine)}", parts
    )


def speed_table(speed: tuple[Speed, ...]) -> Numbers:
    """Table II."""
    columns = (
        "candidates, posture", "in range", "full, Gauss-Seidel", "full, active set", "reduced",
        "reduced / Gauss-Seidel", "reduced / active set", "control, full", "control, reduced",
    )  # fmt: skip
    rows = tuple(
        (
            f"{row.candidates:,}, {row.posture}",
            f"{row.in_range:,}",
            f"{1e3 / row.gauss_seidel_ms:.3g}{'' if row.gauss_seidel_converged else ' *'}",
            f"{1e3 / row.full_ms:.0f}",
            f"{1e3 / row.reduced_ms:.0f}",
            f"{row.gauss_seidel_ms / row.reduced_ms:.1f}",
            f"{row.full_ms / row.reduced_ms:.2f}",
            f"{1e3 / row.control_full_ms:.0f}",
            f"{1e3 / row.control_reduced_ms:.0f}",
        )
        for row in speed
    )
    return Numbers("Steps per second", columns, rows)


def arm_stages_table(times: StepTimes) -> Numbers:
    """Where the time of a control step goes."""
    spreads = {**times.stages_ms, **times.whole_ms}
    title = (
        f"A control step, bent, {times.in_range:,.0f} candidates in range, {times.contact}, "
        f"{times.rows:.0f} contact rows in the QPCC: median / 99 % in ms"
    )
    names = (*STAGES, *WHOLE)
    return Numbers(title, ("", *names), (("", *(milliseconds(spreads[name]) for name in names)),))


def arm_errors_table(result: ArmBench) -> Numbers:
    """Fig. 12, the shipped basis first."""
    columns = (
        "postures", "basis", "k", "certified", "mean [mm]", "largest [mm]", "largest on the way [mm]",
        "unit columns", "not settled",
    )  # fmt: skip
    kinds = [(error, "shipped, ") for error in result.shipped]
    kinds += [(error, "") for error in result.errors]
    title = "Tip of reduced against pointwise contact under the same tensions"
    return Numbers(title, columns, tuple(error_row(error, kind) for error, kind in kinds))


def error_row(error: PostureError, kind: str) -> tuple[str, ...]:
    """A basis on some postures."""
    return (
        error.postures,
        f"{kind}{error.method}",
        str(error.k),
        "yes" if error.certified else "no",
        f"{error.mean_mm:.2f}",
        f"{error.max_mm:.2f}",
        f"{error.path_max_mm:.2f}",
        str(error.extra_columns),
        str(error.unsettled),
    )


def sentences(result: ArmBench) -> tuple[str, str]:
    """Sentences about Gauss-Seidel and about the effect of contact."""
    c = result.contact
    return (
        f"Gauss-Seidel took {max(row.sweeps for row in result.speed):,} sweeps at most, in the median "
        "of a posture; a star marks where it was stopped before it met its tolerance.",
        f"Contact moves the tip {c.apart_mm[0]:.0f} mm; {c.pushing} candidates push with "
        f"{c.contact_force_n:.0f} N together; without contact surfaces overlap by "
        f"{c.deepest_overlap_mm:.1f} mm.",
    )
