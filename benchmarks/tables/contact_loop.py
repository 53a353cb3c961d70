"""The numbers of `python -m benchmarks contact-loop` as tables."""

from __future__ import annotations

from benchmarks.control import WRONG, ContactBench, LiftRun
from tauten.service.tables import Numbers, Page, measured_on


def contact_loop_page(result: ContactBench) -> Page:
    """Errors and forces at a wall, and errors of a cube that is lifted."""
    about = (
        f"Plants take {result.wall_plant_steps} and {result.lift_plant_steps} steps a period. Without the "
        f"wall in its model a controller has targets {result.wall_depth_mm:.1f} mm behind it. Times: "
        f"{measured_on(result.machine)}"
    )
    return Page(
        "python -m benchmarks contact-loop",
        about,
        (_wall(result), _lift(result), _reserves(result)),
    )


def _wall(result: ContactBench) -> Numbers:
    rows = tuple(
        (
            one.controller,
            _loop(one.closed),
            f"{one.along_rms_mm:.2f} / {one.along_max_mm:.2f}",
            f"{one.force_n:.2f}",
            f"{one.force_least_n:.2f} / {one.force_largest_n:.2f}",
            f"{one.step_ms.p50:.0f} / {one.step_ms.p99:.0f}",
            f"{one.unusable}",
        )
        for one in result.wall
    )
    columns = (
        "controller knows", "loop", "error along the wall, RMS / max [mm]", "mean force [N]",
        "least / largest force [N]", "step, median / p99 [ms]", "unusable",
    )  # fmt: skip
    return Numbers("the trunk's tip along a wall with 1 N", columns, rows)


def _lift(result: ContactBench) -> Numbers:
    rows = tuple(
        (
            one.model,
            f"{one.mass:g}",
            f"{one.friction:g}",
            _loop(one.closed),
            f"{one.rms_mm:.2f} / {one.max_mm:.2f}",
            f"{one.end_mm:.2f}",
            _carried(one),
            f"{one.thread_ms.p50:.1f} / {one.thread_ms.p99:.0f}",
            f"{one.step_ms.p50:.0f} / {one.step_ms.p99:.0f}",
            f"{one.unusable}",
        )
        for one in result.lift
    )
    columns = (
        "claw", "mass", "friction", "loop", "error of the cube, RMS / max [mm]", "at the end [mm]",
        "carried of its weight", "step, thread, median / p99 [ms]", "clock [ms]", "unusable",
    )  # fmt: skip
    return Numbers(
        "a cube that is to be lifted, of other mass and friction than believed", columns, rows
    )


def _reserves(result: ContactBench) -> Numbers:
    rows = tuple(
        (
            f"{one.friction_share:g}",
            f"{one.min_slip_margin:g}",
            f"{one.run.rms_mm:.2f} / {one.run.max_mm:.2f}",
            f"{one.run.end_mm:.2f}",
            _carried(one.run),
        )
        for one in result.reserves
    )
    columns = (
        "share of friction", "least margin to slip [N]", "error of the cube, RMS / max [mm]",
        "at the end [mm]", "carried of its weight",
    )  # fmt: skip
    mass, friction = WRONG
    return Numbers(
        f"the full claw in open loop, mass x {mass:g} and friction x {friction:g}, by what decisions leave",
        columns,
        rows,
    )


def _carried(run: LiftRun) -> str:
    return f"{run.carried:.3f}" if run.held else f"{run.carried:.3f}, not held"


def _loop(closed: bool) -> str:
    return "closed" if closed else "open"
