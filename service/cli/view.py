"""`tauten view`: a robot in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tauten.service.cli.options import Basis, Model, Port, YoungScale, ZenohConfig

WebPort = Annotated[
    int, typer.Option("--web-port", min=0, max=65535, help="Port of the page; 0: any free one.")
]


def view(
    robot: Annotated[
        str, typer.Argument(help="A shipped robot's name, a robot file, or a log that ends in .mcap.")
    ],
    simulate: Annotated[
        bool, typer.Option("--simulate", help="Simulate model and robot here, without a node.")
    ] = False,
    web_port: WebPort = 8080,
    browser: Annotated[bool, typer.Option(help="Open the default browser.")] = True,
    seconds: Annotated[
        float | None, typer.Option(min=0.1, help="Duration; default: until Ctrl-C.")
    ] = None,
    basis: Basis = None,
    model: Model = None,
    young_scale: YoungScale = 1.0,
) -> None:
    """Show a robot in the browser: drag the target, see the robot follow."""
    from tauten.service.process import stop_on_signals
    from tauten.service.view import ViewSettings, view_simulation

    settings = ViewSettings(web_port, browser, seconds)
    with stop_on_signals() as stop:
        view_simulation(robot, settings, stop, basis, model, young_scale)
