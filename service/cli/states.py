"""The second half of `tauten reduce --states`: a state basis from the same campaign."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.console import Console

from tauten.service.cli.terminal import progress_bar

if TYPE_CHECKING:
    from tauten.model import ContactSpace, Robot
    from tauten.reduction.campaign import Snapshots
    from tauten.reduction.state import Narrower, StateSettings

LEAST_RESPONSES = 10

States = Annotated[
    bool, typer.Option("--states", help="Compute also a state basis, beside the contact basis.")
]
StateModes = Annotated[
    str,
    typer.Option(
        help='Number of state modes, or "auto": more where the error is larger than the robot file allows.'
    ),
]
Responses = Annotated[
    int | None,
    typer.Option(
        min=0,
        help="Number of static responses to actuators, contacts and effectors beside them; default: 10, or "
        "one for each actuator and component of the effectors where these are more.",
    ),
]
SampleResidual = Annotated[
    float,
    typer.Option(
        help="Relative residual of the forces summed over sampled elements. Smaller ones are tried where the "
        "error is larger than the robot file allows."
    ),
]
KeepInaccurate = Annotated[
    bool,
    typer.Option("--accept-error", help="Keep a state basis whose error is larger than allowed."),
]
Touched = Annotated[
    list[str] | None,
    typer.Option(
        help="Surface that touches what is not in the robot file, as of a robot that this one is a part of; "
        "`skin` for all of it. May be given several times. Default: surfaces that touch obstacles, and those "
        "that no contact of the file names. With --states and the design exploring."
    ),
]
TouchedPoints = Annotated[
    int | None,
    typer.Option(
        min=1,
        help="Number of points on these surfaces at which the reduced model yields to small forces as the "
        "full one does at rest: three more modes a point. Best as many as the contact of the surface "
        "has (`points`). Default: none.",
    ),
]


def number_or_auto(what: str, text: str, fault: type[ValueError]) -> int | Literal["auto"]:
    """A number of modes, or "auto"; a fault, which begins with what it is, for other texts."""
    if text == "auto":
        return "auto"
    if not text.isdecimal():
        raise fault(f"{what} {text!r}: allowed are 1 and more, and auto")
    return int(text)


def state_settings(
    robot: Robot, modes: str, responses: int | None, touched: int, sample: float, seed: int
) -> StateSettings:
    """Settings from the command line; without a number of static responses as many as the robot needs.

    Raises:
        StateBasisError: a value is not allowed.
    """
    from tauten.reduction.state import StateBasisError, StateSettings

    r = number_or_auto("state modes are", modes, StateBasisError)
    if responses is None:
        responses = max(LEAST_RESPONSES, robot.layout.n_e + robot.layout.n_a)
    return StateSettings(r=r, responses=responses, touched=touched, sample=sample, seed=seed)


def save_states(
    robot: Robot,
    snapshots: Snapshots,
    basis: ContactSpace,
    settings: StateSettings,
    path: Path,
    max_tip_error: float | None,
    narrower: Narrower | None,
) -> None:
    """Compute the state basis, compare it with the full model on held-out paths, and save it.

    Where the error of the tip is larger than allowed [m], more modes and elements are tried, then campaigns
    within narrower ranges, if there are any.

    Raises:
        StateBasisError: the error is larger than the robot file allows, and not accepted.
    """
    from tauten.reduction.state import reduce_states, reducible, step_times

    wanted = replace(settings, goal=max_tip_error)
    with progress_bar("state basis") as report:
        states = reduce_states(robot, snapshots, basis, wanted, report, narrower)
    times = step_times(robot, states, basis)
    origin, saved = states.origin, states.save(path)
    pressed = ""
    if origin.pressed_mean is not None and origin.pressed_max is not None:
        mean, largest = 1e3 * origin.pressed_mean, 1e3 * origin.pressed_max
        pressed = f" ({mean:.3g} and {largest:.3g} mm where spheres are in the way)"
    within = ""
    if origin.position_share < 1.0:
        within = f", for positions within {origin.position_share:.0%} of what the actuators reach"
    typer.echo(
        f"{saved}: {origin.r} state modes ({origin.responses} of them responses) of "
        f"{origin.snapshots} snapshots, {origin.sample} of {reducible(robot).n_elements} elements"
        f"{within}; tip off by {1e3 * origin.tip_mean:.3g} mm in the mean, "
        f"{1e3 * origin.tip_max:.3g} mm at most on paths held out{pressed}; {times}"
        + (": serve the full model" if times.slower else "")
    )


def show_states(file: str) -> None:
    """A state basis as a table.

    Raises:
        StateBasisError: it cannot be read.
    """
    from tauten.reduction.state import StateBasis
    from tauten.service.tables import origin_table

    origin = asdict(StateBasis.load(file).origin)
    Console(markup=False).print(origin_table("state basis", file, origin))
