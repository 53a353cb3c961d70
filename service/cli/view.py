"""`tauten view`: a robot in the browser."""

from __future__ import annotations

from typing import Annotated

import typer

from tauten.service.cli.options import Basis, Model, Port, YoungScale, ZenohConfig

# packages of the extra `viewer`, which the viewer imports
_EXTRA = ("viser", "websockets", "msgspec")


class ExtraError(ImportError):
    """An extra that is not installed."""


def view(
    robot: Annotated[
        str,
        typer.Argument(help="Name of a robot that is served; with --simulate also a robot file."),
    ],
    simulate: Annotated[
        bool, typer.Option("--simulate", help="Simulate model and robot here, without a node.")
    ] = False,
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
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """Show a robot in the browser: drag the target, see the robot follow."""
    from tauten.service.process import stop_on_signals
    from tauten.service.wire import Network

    try:
        from tauten.service.view import ViewSettings, view_served, view_simulation
    except ModuleNotFoundError as error:
        raise missing(error) from error

    settings = ViewSettings(web_port, browser, seconds)
    with stop_on_signals() as stop:
        if simulate:
            view_simulation(robot, settings, stop, basis, model, young_scale)
        else:
            view_served(robot, Network(port, zenoh_config), settings, stop)


def missing(error: ModuleNotFoundError) -> ImportError:
    """What to install for a module that is not found; the error itself for any other module."""
    if (error.name or "").partition(".")[0] not in _EXTRA:
        return error
    return ExtraError(
        f"the viewer needs {error.name}, which is not installed: pip install 'tauten[viewer]'"
    )
