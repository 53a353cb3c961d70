"""`tauten compare`: the effect of contact on a robot, as a figure and numbers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from tauten.service.cli.terminal import Json, RobotName, drawable, show_mesh_error, write_json

if TYPE_CHECKING:
    from tauten.model import Robot
    from tauten.model.numerics import Array
    from tauten.service.bench import Comparison


def compare(
    robot: RobotName,
    pull: Annotated[
        list[float] | None,
        typer.Option(
            help="Pulled length in m, one option for each cable; default: of the cables that bend the robot "
            "as the first one does the largest, of the others none."
        ),
    ] = None,
    tension: Annotated[
        list[float] | None, typer.Option(help="Tension of each cable instead [N].")
    ] = None,
    axes: Annotated[str, typer.Option(help="Axes of the picture: right, then up.")] = "xz",
    figure: Annotated[Path, typer.Option(callback=drawable, help="Picture to draw.")] = Path(
        "compare.png"
    ),
    json_file: Json = None,
) -> None:
    """Apply the same command with and without contact: figure, and distance of the effectors."""
    from tauten.model import load_robot
    from tauten.model.load import robot_path
    from tauten.service.bench import compare_equilibria, equilibrium
    from tauten.service.plant import bending_command
    from tauten.service.plots import Side, draw_comparison

    if len(set(axes)) != 2 or not set(axes) <= set("xyz"):
        raise typer.BadParameter(f"--axes is {axes!r}, allowed are two different ones of x, y, z")
    if pull and tension:
        raise typer.BadParameter("give --pull or --tension, not both")
    loaded = load_robot(robot)
    chosen: tuple[Array | None, Array | None]
    if pull:
        chosen = _each(loaded, pull, "--pull", loaded.limits.position_max), None
    elif tension:
        chosen = None, _each(loaded, tension, "--tension", loaded.limits.effort_max)
    else:
        bending = bending_command(loaded)
        chosen = bending.position, bending.effort
    passing = equilibrium(loaded, "none", *chosen)
    touching = passing if loaded.n_c == 0 else equilibrium(loaded, "full", *chosen)
    found = compare_equilibria(loaded, touching, passing)
    side = Side("xyz".index(axes[0]), "xyz".index(axes[1]))
    draw_comparison(loaded, touching, passing, side, figure)
    write_json(found, json_file)
    if loaded.n_c == 0:
        Console(markup=False).print(
            f"{loaded.name} has no contacts: at rest and under the command in {figure}."
        )
        return
    for share, what in zip(found.share, ("with", "without"), strict=True):
        if share < 1.0:
            Console(markup=False).print(
                f"{loaded.name} has no equilibrium {what} contact under more than {share:.0%} of the "
                "command: shown is the last one."
            )
    Console(markup=False).print(
        f"{loaded.name}: {found.pushing} candidates push with {found.contact_force_n:.2f} N together; "
        f"effectors {', '.join(_apart(found, i) for i in range(len(found.apart_mm)))} from where they "
        f"are without contact, where surfaces overlap by {found.deepest_overlap_mm:.2f} mm. "
        f"Drawn in {figure}."
    )
    show_mesh_error(robot_path(robot), loaded)


def _apart(found: Comparison, effector: int) -> str:
    """How far an effector is from where it is without contact, with units."""
    values = (
        (found.apart_mm[effector], "mm"),
        (found.apart_mrad[effector], "mrad"),
        (found.apart_ml[effector], "ml"),
    )
    return " and ".join(f"{value:.2f} {unit}" for value, unit in values if value is not None)


def _each(robot: Robot, values: list[float], option: str, largest: Array) -> Array:
    """One value a cable, within limits."""
    import numpy as np

    found = np.array(values)
    if len(found) != robot.n_a:
        raise typer.BadParameter(
            f"{option} given {len(found)} times, {robot.name} needs one for each actuator: {robot.n_a}"
        )
    if not (np.isfinite(found).all() and (found >= 0.0).all() and (found <= largest).all()):
        raise typer.BadParameter(f"{option} {values}: allowed are 0 to {largest.tolist()}")
    return found
