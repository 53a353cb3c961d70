"""Stages of a control step for each kind of contact, and steps on SOFA's meshes, as tables."""

from __future__ import annotations

from benchmarks.steps import ControlBench, SofaMeshBench
from tauten.service.tables import Numbers, Page, measured_on, milliseconds


def control_page(result: ControlBench) -> Page:
    """Stages of a control step, and how far the tip is from where it is with pointwise contact."""
    parts: tuple[Numbers | str, ...] = (control_table(result), *tip_sentences(result))
    return Page("python -m benchmarks finger", f"Measured on {measured_on(result.machine)}", parts)


def control_table(result: ControlBench) -> Numbers:
    """Stages of a control step with contact none, full and reduced, and errors of the tip."""
    sizes = result.sizes
    title = (
        f"{result.robot}: {sizes.nodes} nodes, {sizes.elements} elements, {sizes.candidates} candidates; "
        f"{result.factorisation}; median / p99 in ms"
    )
    rows = []
    for stage in (*result.control[0].stages_ms, *result.control[0].whole_ms):
        spreads = [{**times.stages_ms, **times.whole_ms}[stage] for times in result.control]
        rows.append((stage, *(milliseconds(value) for value in spreads)))
    rows.append(("tip error [mm]", *(milliseconds(times.tip_error_mm) for times in result.control)))
    rows.append(("status", *(", ".join(times.statuses) for times in result.control)))
    return Numbers(title, ("stage", *(times.contact for times in result.control)), tuple(rows))


def tip_sentences(result: ControlBench) -> list[str]:
    """How far the tip is with reduced contact from where it is with pointwise contact."""
    return [
        f"tip of reduced against pointwise contact, {'with' if error.enriched else 'without'} enrichment: "
        f"mean {error.mean_mm:.3f}, max {error.max_mm:.3f} mm at {error.positions} pulls; deepest gap "
        f"{error.deepest_gap_mm:.3f} mm"
        for error in result.tip_error
    ]


def sofa_meshes_page(result: SofaMeshBench) -> Page:
    """Steps on SOFA's meshes beside its published medians, and stages of the inverse step."""
    rows, stages = [], []
    for robot in result.robots:
        name = (robot.robot, f"{robot.sizes.nodes:,}")
        whole = (("forward", robot.forward_ms), ("inverse", robot.inverse.whole_ms["step"]))
        for kind, spread in whole:
            sofa = robot.sofa_ms.get(kind)
            beside = ("-", "-")
            if sofa is not None and spread.p50 is not None:
                beside = (f"{sofa:.1f}", f"{sofa / spread.p50:.1f}")
            rows.append((*name, kind, milliseconds(spread), *beside))
        parts = {**robot.inverse.stages_ms, **robot.inverse.whole_ms}
        stages.append((robot.robot, *map(milliseconds, parts.values())))
    columns = ("robot", "nodes", "step", "tauten", "SOFA", "SOFA / tauten")
    inverse = result.robots[0].inverse
    about = (
        f"Median / p99 in ms, one thread, on {measured_on(result.machine)} SOFA v25.06 was not run here: its "
        "medians are published ones, from a quiet AMD EPYC at 2.25 GHz with 2 cores."
    )
    tables = (
        Numbers("Whole steps", columns, tuple(rows)),
        Numbers(
            "Stages of the inverse step",
            ("robot", *inverse.stages_ms, *inverse.whole_ms),
            tuple(stages),
        ),
    )
    return Page("python -m benchmarks sofa-meshes", about, tables)
