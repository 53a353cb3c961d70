"""`tauten bench closed-loop`: a controller against the full-order robot, along a path."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.console import Console

from tauten.service.cli.terminal import (
    Json,
    Markdown,
    RobotName,
    progress_bar,
    show_mesh_error,
    show_result,
)


def closed_loop(
    robot: RobotName,
    json_file: Json = None,
    markdown: Markdown = None,
    periods: Annotated[
        list[float] | None,
        typer.Option("--period", min=1.0, help="Of a path in reach, in s; by default 10 and 6."),
    ] = None,
) -> None:
    """A controller against the full-order robot, which has time steps of its own; Ctrl-C keeps finished runs.

    It follows a path in reach with its one effector, and the distance of model and plant is divided into its
    shares.
    """
    from tauten.service.bench import bench_closed_loop
    from tauten.service.process import stop_on_signals
    from tauten.service.setup import load_setup
    from tauten.service.tables import closed_loop_page

    setup, times = load_setup(robot), tuple(periods or (10.0, 6.0))
    with stop_on_signals() as stop, progress_bar("targets in reach") as report:
        result = bench_closed_loop(setup, times, stop, report)
    show_result(result, closed_loop_page(result), json_file, markdown)
    show_mesh_error(setup.path, setup.robot)
    if not result.complete:
        Console(markup=False).print("stopped early: the table has the runs that were done")
