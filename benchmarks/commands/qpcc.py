"""`python -m benchmarks qpcc`: the solver of the inverse problem."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tauten.service.cli.terminal import Json, Markdown, progress_bar, show_result


def qpcc(
    json_file: Json = None,
    markdown: Markdown = None,
    recorded: Annotated[Path | None, typer.Option(help="Folder of recorded problems.")] = None,
    published: Annotated[
        Path | None, typer.Option(help="Folder of published problems, with a problems.csv.")
    ] = None,
) -> None:
    """Times of QPCCs by size, start and QP library; distance of their solutions from the optimum."""
    from benchmarks.qpcc import bench_qpcc
    from benchmarks.tables import qpcc_page

    folder = recorded or Path(__file__).resolve().parents[2] / "tests" / "reference" / "qpcc"
    if not list(folder.glob("*.npz")):
        raise typer.BadParameter(
            f"{folder} has no recorded problems, files that end in .npz: name their folder with --recorded, "
            "in a clone it is tests/reference/qpcc"
        )
    with progress_bar("problems") as report:
        result = bench_qpcc(folder, published, report)
    show_result(result, qpcc_page(result), json_file, markdown)
