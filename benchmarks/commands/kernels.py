"""`python -m benchmarks pack-kernels | check-kernels | first-hour`: what is shipped compiled."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tauten.service.cli.terminal import (
    Json,
    Markdown,
    progress_bar,
    show_result,
    writable,
    write_json,
)


def first_hour(json_file: Json = None, markdown: Markdown = None) -> None:
    """Time the demo: nothing compiled, with the kernels that are shipped, and a second time."""
    from benchmarks.kernels import first_demos
    from benchmarks.tables import first_hour_page

    with progress_bar("demo") as report:
        found = first_demos(report)
    show_result(found, first_hour_page(found), json_file, markdown)


def pack_kernels(
    out: Annotated[
        Path | None,
        typer.Option(callback=writable, help="File; default: where tauten looks for it."),
    ] = None,
    everything: Annotated[
        bool, typer.Option("--everything", help="Also all that was compiled here before.")
    ] = False,
) -> None:
    """Run README's first command and the shipped robots, and pack the kernels that they need."""
    from benchmarks.kernels import LARGEST, pack_kernels
    from tauten.model.kernels import SHIPPED, seed_name

    with progress_bar("packing kernels") as report:
        packed = pack_kernels(out or SHIPPED / seed_name(), report, everything)
    print(f"{packed.file}: {packed.entries} entries, {1e-6 * packed.size:.2f} MB")
    if packed.size > LARGEST:
        print(f"larger than {1e-6 * LARGEST:g} MB: too large for the repository")
        raise typer.Exit(1)


def check_kernels(
    most: Annotated[int, typer.Option(min=0, help="Kernels that may be compiled.")] = 5,
    json_file: Json = None,
) -> None:
    """Run the demo as after installation. Exit code 1: it compiled more kernels than permitted."""
    from benchmarks.kernels import SEEDED, first_demos
    from tauten.model.kernels import seed_file

    file = seed_file()
    if file is None or not file.is_file():
        print("no kernels are shipped for this Python, numba and system: nothing to check")
        return
    with progress_bar("demo") as report:
        (found,) = first_demos(report, (SEEDED,))
    print(f"compiled: {found.compiled} kernels; demo: {found.seconds:.0f} s")
    write_json(found, json_file)
    if found.compiled > most:
        print(f"more than {most}: run python -m benchmarks pack-kernels, and commit {file.name}")
        raise typer.Exit(1)
