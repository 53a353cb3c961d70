"""Errors of meshes as tables: what `tauten check` found, and the meshes that `tauten new` compared."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tauten.service.check import MeshErrorEstimate, RobotCheck, VariantErrors
from tauten.service.new import Trial
from tauten.service.tables.numbers import Numbers, Page, millimetres, percent


def check_page(result: RobotCheck) -> Page:
    """The findings, and the errors of every mesh that was compared."""
    rows = tuple((item.subject, item.level, item.found, item.advice) for item in result.findings)
    findings = Numbers(result.robot, ("", "is", "found", "what to change"), rows, text_columns=4)
    errors = () if result.estimate is None else (error_table(result.estimate),)
    about = f"Result: {result.level}." + ("" if result.complete else " Stopped early.")
    return Page("tauten check", about, (findings, *errors))


def error_table(estimate: MeshErrorEstimate) -> Numbers:
    """Errors of every mesh under every load, the largest ones in the first columns."""
    loads = [load.label for load in estimate.loads]
    shown = loads[:4]  # a terminal's width; the JSON file has all
    columns = ("elements", "nodes", "tension", "tip [mm]", "contact force", *shown)
    title = "errors, largest and tension by load"
    sources = dict.fromkeys(item.source for item in estimate.references if item is not None)
    if sources:
        title += f", against {' and '.join(sources)}"
    if not estimate.complete:
        title += " (stopped early)"
    rows = tuple(error_row(item, len(shown)) for item in estimate.variants)
    return Numbers(title, columns, rows)


def error_row(item: VariantErrors, count: int) -> tuple[str, ...]:
    """One mesh: its largest errors, and those of tension under the first `count` loads."""
    by_load = [percent(error.effort) for error in item.errors[:count]]
    by_load += ["-"] * (count - len(by_load))
    largest = (percent(item.effort), millimetres(item.tip), percent(item.contact))
    return (item.variant.name, f"{item.nodes:,}", *largest, *by_load)


def trial_table(trials: Sequence[Trial], chosen: int) -> Numbers:
    """Sizes, tensions and tips of the meshes of a part, half way of the guessed pull.

    Args:
        trials: coarse to fine.
        chosen: index of the mesh that was taken.
    """
    rows = tuple(
        (
            "taken" if index == chosen else "",
            f"{1e3 * trial.size:.3g}",
            f"{trial.nodes:,}",
            f"{trial.effort:.3g}",
            f"{1e3 * float(np.linalg.norm(trial.tip)):.2f}",
            "unknown" if np.isnan(trial.error) else f"{100.0 * trial.error:.1f}",
        )
        for index, trial in enumerate(trials)
    )
    columns = (
        "",
        "size [mm]",
        "nodes",
        "tension [N]",
        "tip moves [mm]",
        "error, estimated [%]",
    )
    return Numbers("meshes, half way of the guessed pull", columns, rows)
