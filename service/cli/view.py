"""`tauten view`: a robot in the browser."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from tauten.service.cli.bench import Json
from tauten.service.cli.options import Basis, Model, Port, YoungScale, ZenohConfig

# packages of the extra `viewer`, which the viewer imports
_EXTRA = ("viser", "websockets", "msgspec")


class ExtraError(ImportError):
    """An extra that is not installed."""


def view(
    robot: Annotated[
        str,
        typer.Argument(
            help="Name of a robot that is served; with --simulate a robot's name or file; or a log, .mcap."
        ),
    ],
    simulate: Annotated[
        bool, typer.Option("--simulate", help="Simulate model and robot here, without a node.")
    ] = False,
    path: Annotated[
        str | None,
        typer.Option(help="With --simulate: what the target follows, as for `tauten stream`."),
    ] = None,
    export: Annotated[
        Path | None,
        typer.Option(help="Write a log or a simulated path as an HTML file that plays by itself."),
    ] = None,
    web_port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port of the page; 0: any free one.")
    ] = 8080,
    browser: Annotated[bool, typer.Option(help="Open the default browser.")] = True,
    seconds: Annotated[
        float | None, typer.Option(min=0.1, help="Duration; default: until Ctrl-C.")
    ] = None,
    basis: Basis = None,
    model: Model = None,
    young_scale: YoungScale = 1.0,
    against: Annotated[
        str | None, typer.Option(help="Robot to use instead of a log's: name or file.")
    ] = None,
    recorded_paths: Annotated[
        bool, typer.Option("--recorded-paths", help="As for `tauten replay`.")
    ] = False,
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """Show a robot in the browser: drag the target, see the robot follow."""
    from tauten.service.process import stop_on_signals
    from tauten.service.wire import Network

    try:
        from tauten.service import view as viewer
    except ModuleNotFoundError as error:
        raise missing(error) from error

    settings = viewer.ViewSettings(web_port, browser, seconds)
    simulation = viewer.SimulationSettings(robot, basis, model, young_scale, path)
    is_log = robot.endswith(".mcap")
    if not simulate and not is_log and (path or export):
        raise typer.BadParameter("--path needs --simulate, --export needs a log or --simulate")
    with stop_on_signals() as stop:
        if export is not None:
            if is_log:
                count = viewer.export_log(Path(robot), export, against, recorded_paths)
            else:
                count = viewer.export_simulation(simulation, seconds, export, stop)
            typer.echo(f"{export}: {count} frames")
        elif is_log:
            viewer.view_log(Path(robot), settings, stop, against, recorded_paths)
        elif simulate:
            viewer.view_simulation(simulation, settings, stop)
        else:
            viewer.view_served(robot, Network(port, zenoh_config), settings, stop)


def bench_view(
    robots: Annotated[list[str], typer.Argument(help="Shipped robots' names, or robot files.")],
    seconds: Annotated[float, typer.Option(min=1.0, help="Duration of the pictures.")] = 20.0,
    path: Annotated[str, typer.Option(help="What the target follows meanwhile.")] = "circle",
    basis: Basis = None,
    model: Model = None,
    json_file: Json = None,
    markdown: Annotated[Path | None, typer.Option(help="Page to put the table into.")] = None,
) -> None:
    """Measure what the viewer costs: pictures a second, processor share, time of a picture.

    Motion is simulated first and then shown to a client in a process of its own. Ctrl-C keeps
    finished results.
    """
    from tauten.service.process import stop_on_signals, write_text
    from tauten.service.tables import view_table, write_view_table

    try:
        from tauten.service import view as viewer
    except ModuleNotFoundError as error:
        raise missing(error) from error

    costs = []
    with stop_on_signals() as stop:
        for robot in robots:
            simulation = viewer.SimulationSettings(robot, basis, model, 1.0, path)
            found = viewer.simulation_cost(simulation, seconds, stop)
            if found is not None:
                costs.append(found)
    if not costs:
        return
    if json_file is not None:
        write_text(json_file, json.dumps([asdict(cost) for cost in costs], indent=2) + "\n")
    if markdown is not None:
        write_view_table(costs, markdown)
    Console().print(view_table(costs).rich())


def missing(error: ModuleNotFoundError) -> ImportError:
    """What to install for a module that is not found; the error itself for any other module."""
    if (error.name or "").partition(".")[0] not in _EXTRA:
        return error
    return ExtraError(
        f"the viewer needs {error.name}, which is not installed: pip install 'tauten[viewer]'"
    )
