"""`python -m benchmarks friction`: the solver of contact with friction."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tauten.service.cli.terminal import Json, Markdown, progress_bar, show_result


def friction(
    data: Annotated[
        Path, typer.Option(envvar="TAUTEN_REFERENCE_DATA", help="Folder of the reference data.")
    ],
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
