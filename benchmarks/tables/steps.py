"""Stages of a control step for each kind of contact, steps on SOFA's and on refined meshes, as tables."""

from __future__ import annotations

from benchmarks.steps import STAGES, WHOLE, ControlBench, MeshCase, ReducedMeshes, SofaMeshBench
from tauten.service.tables import Numbers, Page, measured_on, milliseconds, tip_distance


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


def reduced_meshes_page(result: ReducedMeshes) -> Page:
    """Full and reduced models by mesh, and where the time of a step goes."""
    parts = meshes_table(result.meshes), mesh_stages_table(result.meshes)
    about = f"{result.robot}. Measured on {measured_on(result.machine)}"
    return Page("python -m benchmarks reduced-meshes", about, parts)


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
            str(mesh.modes), str(mesh.elements), tip_distance(mesh.training),
            *(milliseconds(times.whole_ms["step"]) for times in (mesh.full, mesh.reduced, mesh.fast)),
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
                row.append(milliseconds({**times.stages_ms, **times.whole_ms}[stage]))
        rows.append(tuple(row))
    return Numbers("Stages of a step, median / 99 % in ms", tuple(columns), tuple(rows))
