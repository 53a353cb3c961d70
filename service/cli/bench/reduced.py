"""`tauten bench reduced`: modes and sampled elements against errors and step times."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tauten.service.cli.terminal import (
    Json,
    Markdown,
    RobotName,
    basis_of,
    progress_bar,
    show_result,
    writable,
)


def reduced(
    robot: RobotName,
    json_file: Json = None,
    markdown: Markdown = None,
    basis: Annotated[
        str | None, typer.Option(help="Contact basis to use instead of the robot file's.")
    ] = None,
    seconds: Annotated[float, typer.Option(min=1.0, help="Duration of the path.")] = 12.0,
    snapshots: Annotated[
        Path | None,
        typer.Option(
            callback=writable, help="Folder of the reduced models' campaigns; default: ROBOT-bench."
        ),
    ] = None,
) -> None:
    """Number of state modes and sampled elements against errors and step times of reduced models."""
    from tauten.service.bench import bench_reduced
    from tauten.service.setup import load_setup
    from tauten.service.tables import reduced_page

    setup = load_setup(robot, basis=basis, model="full")
    modes = basis_of(setup, robot)
    folder = snapshots or Path(f"{setup.robot.name}-bench")
    with progress_bar("reduced models") as report:
        result = bench_reduced(robot, modes, folder, seconds, report)
    show_result(result, reduced_page(result), json_file, markdown)
