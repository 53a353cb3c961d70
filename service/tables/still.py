"""The numbers of `tauten bench still` as tables."""

from __future__ import annotations

import numpy as np

from tauten.service.bench import StillBench, StillRun
from tauten.service.tables.numbers import Numbers, Page, measured_on


def still_page(result: StillBench) -> Page:
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
                _median([run.rest_s for run in runs if run.rest_s is not None]),
                str(sum(run.is_best for run in best)) if best else "–",
                str(sum(run.is_near for run in best)) if best else "–",
                _farther(best),
                f"{max(run.position for run in runs):.1e}", f"{max(run.effort for run in runs):.1e}",
            )
        )  # fmt: skip
    tables = [
        Numbers(
            "constant targets within twice the workspace",
            (
                *(
                    "robot",
                    "model",
                    "loop",
                    "contact",
                    "targets",
                    "at rest",
                    "seconds to rest, median",
                ),
                *(
                    "within 1 % of the best place",
                    "and 0.1 % of the way",
                    "farther than it, at most [mm]",
                ),
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
    minutes, asked = result.settings.minutes, result.settings.targets
    about = (
        f"{asked} targets of each group, fewer where {minutes:g} minutes for a robot and its model were not "
        f"enough. Measured on {measured_on(result.machine)}"
    )
    return Page("tauten bench still", about, tuple(tables))


def _farther(runs: list[StillRun]) -> str:
    """How much farther from the target than the best place a run ends, at most."""
    lengths = [run.error_mm - run.best_mm for run in runs if run.best_mm is not None]
    return f"{max(lengths):.3f}" if lengths else "–"


def _median(values: list[float]) -> str:
    return f"{float(np.median(values)):.2f}" if values else "–"
