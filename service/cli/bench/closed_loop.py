"""`tauten bench closed-loop`: controllers against the full-order robot, along a path and case by case."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from tauten.service.cli.terminal import (
    Json,
    Markdown,
    RobotName,
    basis_of,
    progress_bar,
    show_mesh_error,
    show_result,
)

PERIODS = (10.0, 6.0)  # s


def closed_loop(
    robot: RobotName,
    json_file: Json = None,
    figures: Annotated[Path | None, typer.Option(help="Folder for a figure of each case.")] = None,
    markdown: Markdown = None,
    periods: Annotated[
        list[float] | None,
        typer.Option(
            "--period",
            min=1.0,
            help="Of a path in reach, in s; by default 10 and 6.",
        ),
    ] = None,
    cases: Annotated[bool, typer.Option("--cases", help="Run the five cases too.")] = False,
    seconds: Annotated[float, typer.Option(min=1.0, help="Duration of each case.")] = 4.0,
    seed: Annotated[int, typer.Option(help="Seed of the random walk.")] = 0,
) -> None:
    """A controller against the full-order robot, which has time steps of its own; Ctrl-C keeps finished runs.

    It follows a path in reach, where it has one effector, and the distance of model and plant is divided into
    its shares. With --cases, controllers with reduced, full and no contact go through five cases too.
    """
    from tauten.service.bench import ClosedLoopSettings, bench_closed_loop
    from tauten.service.plots import draw_case
    from tauten.service.process import stop_on_signals
    from tauten.service.setup import load_setup
    from tauten.service.tables import closed_loop_page

    setup = load_setup(robot)
    usual = PERIODS if len(setup.robot.effector_names) == 1 else ()
    times = usual if periods is None else tuple(periods)
    settings = ClosedLoopSettings(seconds, seed, times, cases or not times)
    contact = basis_of(setup, robot) if settings.cases else setup.contact
    with stop_on_signals() as stop, progress_bar("targets in reach") as report:
        result, runs = bench_closed_loop(setup.robot, setup.path, contact, settings, stop, report)
    show_result(result, closed_loop_page(result), json_file, markdown)
    show_mesh_error(setup.path, setup.robot)
    if not result.complete:
        Console(markup=False).print("stopped early: the tables have the runs that were done")
    if figures is not None:
        figures.mkdir(parents=True, exist_ok=True)
        for one in runs:
            draw_case(one, setup.robot.h, figures / f"{one.name}.png")
