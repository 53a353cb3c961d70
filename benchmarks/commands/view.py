"""`python -m benchmarks view`: what the viewer costs."""

from __future__ import annotations

from typing import Annotated

import typer

from tauten.service.cli.terminal import (
    Basis,
    Json,
    Markdown,
    Model,
    missing_extra,
    show_result,
)


def view(
    robots: Annotated[list[str], typer.Argument(help="Shipped robots' names, or robot files.")],
    seconds: Annotated[float, typer.Option(min=1.0, help="Duration of the pictures.")] = 20.0,
    path: Annotated[str, typer.Option(help="What the target follows meanwhile.")] = "circle",
    basis: Basis = None,
    model: Model = None,
    json_file: Json = None,
    markdown: Markdown = None,
) -> None:
    """Measure what the viewer costs: pictures a second, processor share, time of a picture.

    Motion is simulated first and then shown to a client in a process of its own. Ctrl-C keeps
    finished results.
    """
    from benchmarks.tables import view_page
    from tauten.service.process import stop_on_signals

    try:
        from benchmarks.view import simulation_cost
        from tauten.service.view import SimulationSettings
    except ModuleNotFoundError as error:
        raise missing_extra(error) from error

    costs = []
    with stop_on_signals() as stop:
        for robot in robots:
            simulation = SimulationSettings(robot, basis, model, 1.0, path)
            found = simulation_cost(simulation, seconds, stop)
            if found is not None:
                costs.append(found)
    if costs:
        show_result(costs, view_page(costs), json_file, markdown)
