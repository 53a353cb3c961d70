"""`tauten bench closed-loop`: controllers against the full-order robot, case by case."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from tauten.service.cli.terminal import (
    Json,
    Markdown,
    basis_of,
    progress_bar,
    show_mesh_error,
    show_result,
)


def closed_loop(
    robot: Annotated[str, typer.Argument(help="A shipped robot's name, or a robot file.")],
    json_file: Json = None,
    figures: Annotated[Path | None, typer.Option(help="Folder for a figure of each case.")] = None,
    markdown: Markdown = None,
    seconds: Annotated[float, typer.Option(min=1.0, help="Duration of each case.")] = 4.0,
    seed: Annotated[int, typer.Option(help="Seed of the random walk.")] = 0,
) -> None:
    """Controllers with reduced, full and no contact on the full-order robot; Ctrl-C keeps finished runs."""
    from tauten.service.bench import ClosedLoopSettings, bench_closed_loop
    from tauten.service.plots import draw_case
    from tauten.service.process import stop_on_signals
    from tauten.service.setup import load_setup
    from tauten.service.tables import closed_loop_page

    setup = load_setup(robot)
    basis = basis_of(setup, robot)
    settings = ClosedLoopSettings(seconds, seed)
    with stop_on_signals() as stop, progress_bar("targets in reach") as report:
        result, runs = bench_closed_loop(setup.robot, setup.path, basis, settings, stop, report)
    show_result(result, closed_loop_page(result), json_file, markdown)
    show_mesh_error(setup.path, setup.robot)
    if not result.complete:
        Console().print("stopped early: the tables have the runs that were done")
    if figures is not None:
        figures.mkdir(parents=True, exist_ok=True)
        for one in runs:
            draw_case(one, setup.robot.h, figures / f"{one.name}.png")
