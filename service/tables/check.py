"""What `tauten check` found as tables, for the terminal and for the docs."""

from __future__ import annotations

from tauten.service.check import MeshErrorEstimate, RobotCheck, VariantErrors
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
