"""`tauten view`: a robot in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tauten.service.cli.terminal import (
    Basis,
    Model,
    Port,
    YoungScale,
    ZenohConfig,
    missing_extra,
    progress_bar,
    writable,
)
from tauten.service.link import served_name


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
        typer.Option(
            callback=writable,
            dir_okay=False,
            help="Write a log or a simulated path as an HTML file that plays by itself.",
        ),
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
        raise missing_extra(error) from error

    settings = viewer.ViewSettings(web_port, browser, seconds)
    simulation = viewer.SimulationSettings(robot, basis, model, young_scale, path)
    is_log = robot.endswith(".mcap")
    if not simulate and not is_log and (path or export):
        raise typer.BadParameter("--path needs --simulate, --export needs a log or --simulate")
    if not simulate and robot.endswith(".toml"):
        raise typer.BadParameter(
            f"{robot} is a robot file: add --simulate, or where it is served: "
            f"tauten view {served_name(robot)}"
        )
    if (simulate or is_log) and port is not None:
        raise typer.BadParameter("--port is Zenoh's, of a served robot; the page's is --web-port")
    if export is None:
        viewer.check_port(web_port)  # before what takes long
    with stop_on_signals() as stop:
        if export is not None:
            with progress_bar("export") as report:
                if is_log:
                    log = Path(robot), export, stop, report, against, recorded_paths
                    count = viewer.export_log(*log)
                else:
                    count = viewer.export_simulation(simulation, seconds, export, stop, report)
            typer.echo(f"{export}: {count} frames")
        elif is_log:
            viewer.view_log(Path(robot), settings, stop, against, recorded_paths)
        elif simulate:
            viewer.view_simulation(simulation, settings, stop)
        else:
            viewer.view_served(robot, Network(port, zenoh_config), settings, stop)
