"""The numbers of `tauten bench energy` and `tauten bench equilibria` as tables."""

from __future__ import annotations

from pathlib import Path

from tauten.service.bench.physics import EnergyBench, EquilibriaBench, StillBench
from tauten.service.tables.numbers import Numbers, measured_on, put_tables

ENERGY_BEGIN, EQUILIBRIA_BEGIN = "<!-- tauten bench energy -->", "<!-- tauten bench equilibria -->"
PHYSICS_END = "<!-- end -->"


def energy_tables(result: EnergyBench) -> tuple[Numbers, ...]:
    """Energies, times of steps, and shares of the distance of model and plant."""
    courses = [
        (
            item.robot, item.motion, item.steps, f"{1e3 * item.energy[0]:.3g}",
            f"{100.0 * item.largest_rise:.2g} %", f"{100.0 * item.left:.2g} %",
        )
        for item in result.courses
    ]  # fmt: skip
    costs = [
        (
            item.robot, f"{item.period_ms:.1f}", f"{item.single_ms.p50:.1f} / {item.single_ms.p99:.1f}",
            f"{item.converged_ms.p50:.1f} / {item.converged_ms.p99:.1f}", f"{item.iterations:.1f}",
        )
        for item in result.costs
    ]  # fmt: skip
    shares = [
        (found.distances.robot, name, f"{share.rms_mm:.3f}", f"{share.max_mm:.3f}")
        for found in result.paths
        for name, share in found.distances.shares().items()
    ]
    tables = [
        Numbers(
            "energy of motions without damping",
            (
                "robot",
                "motion",
                "steps",
                "at start [mJ]",
                "largest rise in a step",
                "left at the end",
            ),
            tuple(courses),
            3,
        ),
        Numbers(
            "times of a plant's steps, median / 99th percentile",
            ("robot", "period [ms]", "single [ms]", "converged [ms]", "linearisations"),
            tuple(costs),
        ),
    ]
    if shares:
        title = "distance of model and plant on the demo's path, no tick late"
        columns = ("robot", "share", "RMS [mm]", "largest [mm]")
        tables.append(Numbers(title, columns, tuple(shares), 2))
        title = "distance from steps a quarter as long under the same pulled lengths"
        columns = ("robot", "steps", "RMS [mm]", "largest [mm]")
        lengths = [
            (found.distances.robot, item.steps, f"{item.rms_mm:.3f}", f"{item.max_mm:.3f}")
            for found in result.paths
            for item in found.step_lengths
        ]  # fmt: skip
        tables.append(Numbers(title, columns, tuple(lengths), 2))
    return tuple(tables)


def equilibria_tables(result: EquilibriaBench) -> tuple[Numbers, ...]:
    """Searches, how many converged, and the linearised steps and factorisations they took."""
    rows = [
        (
            item.name, str(item.searches), str(item.converged), f"{item.median:g}", str(item.most),
            f"{item.median_factorisations:g}", str(item.most_factorisations),
            ", ".join(f"{count}: {text}" for text, count in item.endings.items()) or "-",
        )
        for item in result.groups
    ]  # fmt: skip
    columns = (
        "robot and load",
        "searches",
        "found",
        "steps",
        "most",
        "factorisations",
        "most",
        "others",
    )
    return (Numbers("", columns, tuple(rows)),)


def write_energy_tables(result: EnergyBench, path: Path) -> None:
    """Put the tables into a page, see `put_tables`."""
    about = f"One thread. Times: {measured_on(result.machine)}"
    put_tables(path, ENERGY_BEGIN, PHYSICS_END, about, energy_tables(result))


def write_equilibria_tables(result: EquilibriaBench, path: Path) -> None:
    """Put the table into a page, see `put_tables`."""
    about = (
        "Median and largest number of linearised steps and of factorisations, those that failed "
        "because a tangent was not definite included."
    )
    put_tables(path, EQUILIBRIA_BEGIN, PHYSICS_END, about, equilibria_tables(result))


def still_tables(result: StillBench) -> tuple[Numbers, ...]:
    """Share of the runs at rest and at the best place, by robot, and random orders."""
    groups = dict.fromkeys(
        (run.robot, run.model, run.loop, run.contact) for run in result.runs
    )  # in order
    rows = []
    for robot, model, loop, contact in groups:
        runs = [
            run
            for run in result.runs
            if (run.robot, run.model, run.loop, run.contact) == (robot, model, loop, contact)
        ]
        best = [run for run in runs if run.best_mm is not None]
        rows.append(
            (
                robot, model, loop, "yes" if contact else "no", str(len(runs)),
                str(sum(run.rests for run in runs)),
                str(sum(run.is_best for run in best)) if best else "–",
                f"{max(run.position for run in runs):.1e}", f"{max(run.effort for run in runs):.1e}",
            )
        )  # fmt: skip
    tables = [
        Numbers(
            "constant targets within twice the workspace",
            (
                *("robot", "model", "loop", "contact", "targets", "at rest", "at the best place"),
                *("largest change of a position", "of an effort"),
            ),
            tuple(rows),
            4,
        )
    ]
    if result.orders:
        found = tuple(
            (
                item.robot, str(item.orders), str(item.unusable), str(item.stuck),
                f"{item.beyond:.1e}", f"{item.needed:.1e}",
            )
            for item in result.orders
        )  # fmt: skip
        title = "random locks, holds, unlocks and targets"
        columns = ("robot", "orders", "unusable", "stuck after", "left beyond", "needed beyond")
        tables.append(Numbers(title, columns, found))
    return tuple(tables)
