"""Errors of meshes as tables: what `tauten check` found, and the meshes that `tauten new` compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tauten.service.check import MESH_ERROR, PERIOD, MeshErrorEstimate, RobotCheck, VariantErrors
from tauten.service.new import Made, Trial
from tauten.service.tables.numbers import Numbers, Page, millimetres, percent


def check_page(result: RobotCheck) -> Page:
    """The findings, and the errors of every mesh that was compared."""
    findings = findings_table(result)
    errors = () if result.estimate is None else (error_table(result.estimate),)
    about = f"Result: {result.level}." + ("" if result.complete else " Stopped early.")
    return Page("tauten check", about, (findings, *errors))


def new_page(made: Made) -> Page:
    """The meshes of a new robot that were compared, and what was found about the one that is written."""
    unit = "Pa" if made.guess.cavities else "N"
    trials = trial_table(made.trials, made.chosen, unit)
    about = f"Result: {made.check.level}."
    # what to do about mesh and time of a step is one question, which the verdict of the command answers
    findings = tuple(
        replace(item, advice="") if item.subject in (MESH_ERROR, PERIOD) else item
        for item in made.check.findings
    )
    return Page(
        "tauten new", about, (trials, findings_table(replace(made.check, findings=findings)))
    )


def findings_table(result: RobotCheck) -> Numbers:
    """Every finding, with what to change after an arrow."""
    rows = tuple(
        (item.subject, item.level, f"{item.found} → {item.advice}" if item.advice else item.found)
        for item in result.findings
    )
    return Numbers(result.robot, ("", "is", "found → what to change"), rows, text_columns=3)


def error_table(estimate: MeshErrorEstimate) -> Numbers:
    """Errors of every mesh under every load, the largest ones in the first columns."""
    loads = [load.label for load in estimate.loads]
    shown = loads[:4]  # a terminal's width; the JSON file has all
    columns = ("elements", "nodes", estimate.effort_name, "tip [mm]", "contact force", *shown)
    title = f"errors, largest and {estimate.effort_name} by load"
    if estimate.against:
        title += f", against {estimate.against}"
    if not estimate.complete:
        title += " (stopped early)"
    rows = tuple(error_row(item, len(shown)) for item in estimate.variants)
    return Numbers(title, columns, rows)


def error_row(item: VariantErrors, count: int) -> tuple[str, ...]:
    """One mesh: its largest errors, and those of efforts under the first `count` loads."""
    by_load = [percent(error.effort) for error in item.errors[:count]]
    by_load += ["-"] * (count - len(by_load))
    largest = (percent(item.effort), millimetres(item.tip), percent(item.contact))
    return (item.variant.name, f"{item.nodes:,}", *largest, *by_load)


def trial_table(trials: Sequence[Trial], chosen: int, unit: str) -> Numbers:
    """Sizes, efforts, tips and control steps of the meshes of a part, half way of the guessed command."""
    rows = tuple(
        (
            "taken" if index == chosen else "",
            f"{1e3 * trial.size:.3g}",
            f"{trial.nodes:,}",
            f"{trial.reached.effort:.3g}",
            f"{1e3 * trial.reached.moved:.2f}",
            "-" if np.isnan(trial.difference) else f"{100.0 * trial.difference:.1f}",
            "-" if np.isnan(trial.step) else f"{1e3 * trial.step:.0f}",
        )
        for index, trial in enumerate(trials)
    )
    columns = (
        "",
        "size [mm]",
        "nodes",
        f"effort [{unit}]",
        "tip moves [mm]",
        "differs from the finest [%]",
        "control step [ms]",
    )
    return Numbers("meshes, half way of the guess", columns, rows)
