"""The numbers of `python -m benchmarks energy` and `python -m benchmarks equilibria` as tables."""

from __future__ import annotations

from benchmarks.physics import EnergyBench, EquilibriaBench
from tauten.service.tables import Numbers, Page, measured_on


def energy_page(result: EnergyBench) -> Page:
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
    about = f"One thread. Times: {measured_on(result.machine)}"
    return Page("python -m benchmarks energy", about, tuple(tables))


def equilibria_page(result: EquilibriaBench) -> Page:
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
    about = (
        "Median and largest number of linearised steps and of factorisations, those that failed "
        "because a tangent was not definite included."
    )
    return Page("python -m benchmarks equilibria", about, (Numbers("", columns, tuple(rows)),))
