"""`tauten bench steps`: times of whole steps without contact."""

from __future__ import annotations

from typing import Annotated

import typer

from tauten.service.cli.terminal import Json, progress_bar, show_mesh_error, show_result


def steps(
    robot: Annotated[str, typer.Argument(help="A robot file.")],
    refinements: Annotated[int, typer.Option(min=0, max=3, help="Uniform refinements.")] = 0,
    factorisation: Annotated[str, typer.Option(help="auto, pardiso, cholmod, superlu.")] = "auto",
    count: Annotated[int, typer.Option("--steps", min=5, help="Number of steps to measure.")] = 100,
    json_file: Json = None,
) -> None:
    """Forward and inverse steps without contact, on a mesh and its refinements."""
    from tauten.model import load_robot
    from tauten.model.load import robot_path
    from tauten.service.bench import bench_steps
    from tauten.service.tables import steps_page

    with progress_bar(f"steps of {robot}") as report:
        result = bench_steps(robot, refinements, factorisation, count, report)
    show_result(result, steps_page(result), json_file)
    show_mesh_error(robot_path(robot), load_robot(robot, refinements=refinements))
