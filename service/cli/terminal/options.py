"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from tauten.service.cli.terminal.output import writable
from tauten.service.link import HIGHEST_PORT, LOWEST_PORT, ZENOH_CONFIG_VARIABLE, served_name

if TYPE_CHECKING:
    from tauten.reduction import ContactBasis
    from tauten.service.setup import Setup

ServedName = Annotated[
    str,
    typer.Argument(callback=served_name, help="Name of the robot that is served, or its file."),
]
RobotName = Annotated[str, typer.Argument(help="A shipped robot's name, or a robot file.")]
Robots = Annotated[list[str] | None, typer.Option(help="A robot's name or file; may be repeated.")]
Rate = Annotated[
    float | None, typer.Option(min=0.1, help="Control rate [Hz]; default: the robot file's.")
]
Basis = Annotated[
    str | None,
    typer.Option(help='Contact basis, "none" or "full"; default: the robot file\'s.'),
]
Model = Annotated[
    Literal["full", "reduced"] | None,
    typer.Option(
        help="Full model, or the reduced model of a state basis; default: the robot file's."
    ),
]
AcceptError = Annotated[
    bool,
    typer.Option("--accept-error", help="Accept a state basis whose error is larger than allowed."),
]
Port = Annotated[
    int | None,
    typer.Option(
        min=LOWEST_PORT,
        max=HIGHEST_PORT,
        help="The node's TCP port; default: from the robot's name. Not with --zenoh-config.",
    ),
]
ZenohConfig = Annotated[
    Path | None,
    typer.Option(
        envvar=ZENOH_CONFIG_VARIABLE, help="Zenoh configuration file instead of peers on loopback."
    ),
]
ClosedLoop = Annotated[
    bool, typer.Option("--closed-loop", help="Correct the targets by measurements.")
]
Period = Annotated[
    float | None,
    typer.Option(
        min=0.1,
        help="Duration of one pass in s; default: 10, for reach longer where the robot would have to hurry.",
    ),
]
YoungScale = Annotated[
    float,
    typer.Option(
        min=0.01, max=100.0, help="Ratio of the plant's Young's modulus to the robot file's."
    ),
]
StepsOption = Annotated[
    Literal["own", "single", "converged"],
    typer.Option(
        "--steps",
        help="The plant's time steps: its own, so short that their error is below half a per cent; the "
        "controller's, with one linearisation; or these iterated to convergence.",
    ),
]
DriveOption = Annotated[
    Literal["pull", "tension"],
    typer.Option("--drive", help="Command that the plant's winches follow."),
]
Json = Annotated[
    Path | None,
    typer.Option(
        "--json", callback=writable, dir_okay=False, help="Write the numbers to this file."
    ),
]
Markdown = Annotated[
    Path | None,
    typer.Option(
        callback=writable, exists=True, dir_okay=False, help="Page to put the tables into."
    ),
]


def basis_of(setup: Setup, robot: str) -> ContactBasis:
    """The contact basis of a setup, which a benchmark needs.

    Raises:
        typer.BadParameter: it has none.
    """
    if isinstance(setup.contact, str):
        advice = f"tauten reduce {robot} makes one" if setup.robot.n_c else "it has no contacts"
        raise typer.BadParameter(f"{robot} has no contact basis: {advice}")
    return setup.contact
