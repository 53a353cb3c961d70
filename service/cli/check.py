"""`tauten check` and `tauten schema`: what a robot file may hold, and how wrong a robot is."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tauten.service.cli.terminal import (
    Json,
    Markdown,
    RobotName,
    drawable,
    progress_bar,
    show_result,
)

if TYPE_CHECKING:
    from tauten.service.check import MeshErrorEstimate, RobotCheck


def check(
    robot: RobotName,
    json_file: Json = None,
    figure: Annotated[
        Path | None, typer.Option(callback=drawable, help="Picture of errors over nodes to draw.")
    ] = None,
    regions: Annotated[
        Path | None,
        typer.Option(callback=drawable, help="Picture of what each region selects, to draw."),
    ] = None,
    markdown: Markdown = None,
    share: Annotated[
        list[float] | None,
        typer.Option(min=0.01, max=1.0, help="Share of each cable's largest pull, or several."),
    ] = None,
    refinements: Annotated[
        int,
        typer.Option(min=0, max=3, help="Refinements to compare with; from 2 on extrapolated."),
    ] = 1,
    save: Annotated[
        bool,
        typer.Option("--save", help="Save the errors beside the robot file, for later reports."),
    ] = False,
    compare: Annotated[
        bool, typer.Option("--compare/--no-compare", help="Compare with better meshes.")
    ] = True,
) -> None:
    """Error of the mesh in effort, tip and contact force; elements, units, regions, mass, sag, walls.

    The exit code is 1 where something is wrong, 2 where the robot cannot be built. Ctrl-C keeps what is done.
    """
    from tauten.model import RobotFileError
    from tauten.model.load import robot_path
    from tauten.service.check import CheckSettings, check_robot, selected
    from tauten.service.plots import draw_mesh_error, draw_regions
    from tauten.service.process import stop_on_signals
    from tauten.service.tables import check_page

    shares = tuple(share or (0.25, 0.5)) if compare else ()
    settings = CheckSettings(robot, shares, refinements)
    with stop_on_signals() as stop, progress_bar("check") as report:
        result = check_robot(settings, stop, report)
    numbers = {**asdict(result), "level": result.level}
    show_result(numbers, check_page(result), json_file, markdown)
    if result.refused:
        raise RobotFileError(result.refused)
    if save:
        _save(result, robot_path(robot))
    if regions is not None:
        draw_regions(*selected(robot), regions)
    if figure is not None:
        draw_mesh_error(_estimate(result, robot_path(robot), "--figure"), figure)
    if result.level == "wrong":
        raise typer.Exit(1)


def schema() -> None:
    """Print the JSON Schema of a robot file, with which editors complete and check it."""
    from tauten.service.file_schema import robot_file_schema

    typer.echo(json.dumps(robot_file_schema(), indent=2, ensure_ascii=False))


def _estimate(result: RobotCheck, path: Path, option: str) -> MeshErrorEstimate:
    """The comparison of meshes of the robot file at `path` that an option is about."""
    from tauten.service.check import not_compared

    if result.estimate is None:
        why = not_compared(path) or "leave out --no-compare"
        raise typer.BadParameter(
            f"{option}: there are no errors without a comparison of meshes; {why}"
        )
    return result.estimate


def _save(result: RobotCheck, path: Path) -> None:
    """Save the errors beside the robot file at `path`."""
    from tauten.service.check import certified

    try:
        certified(_estimate(result, path, "--save"), result.digest).save(path)
    except ValueError as error:
        raise typer.BadParameter(f"--save: {error}") from error
