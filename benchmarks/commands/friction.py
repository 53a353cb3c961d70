"""`python -m benchmarks friction`, `friction-inverse`, `friction-modes`: solvers of contact with friction."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tauten.service.cli.terminal import Json, Markdown, progress_bar, show_result

Data = Annotated[
    Path, typer.Option(envvar="TAUTEN_REFERENCE_DATA", help="Folder of the reference data.")
]


def friction(
    data: Data,
    json_file: Json = None,
    markdown: Markdown = None,
) -> None:
    """Contact problems with friction that others wrote: errors, Newton steps and times."""
    from benchmarks.friction import bench_friction
    from benchmarks.tables import friction_page

    folder = data / "friction_problems"
    if not list(folder.glob("*.npz")):
        raise typer.BadParameter(f"{data} has no friction_problems with files that end in .npz")
    with progress_bar("problems") as report:
        result = bench_friction(folder, report)
    show_result(result, friction_page(result), json_file, markdown)


def friction_inverse(
    data: Data,
    json_file: Json = None,
    markdown: Markdown = None,
) -> None:
    """Inverse problems with friction: excess over the best known, linear systems, and cut searches."""
    from benchmarks.friction import bench_friction_inverse
    from benchmarks.tables import friction_inverse_page

    folder = data / "friction_inverse"
    if not (folder / "problems.csv").is_file():
        raise typer.BadParameter(f"{data} has no friction_inverse with a file problems.csv")
    with progress_bar("problems") as report:
        result = bench_friction_inverse(folder, report)
    show_result(result, friction_inverse_page(result), json_file, markdown)


def friction_modes(json_file: Json = None, markdown: Markdown = None) -> None:
    """What modes that normal and tangential forces share are worth beside unit columns."""
    from benchmarks.friction import bench_shared_modes
    from benchmarks.tables import friction_modes_page

    with progress_bar("robots") as report:
        result = bench_shared_modes(report)
    show_result(result, friction_modes_page(result), json_file, markdown)
