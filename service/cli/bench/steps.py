"""`tauten bench steps`, `sofa-meshes` and `gallery`: times of whole steps."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tauten.service.cli.terminal import (
    Json,
    Markdown,
    progress_bar,
    show_mesh_error,
    show_tables,
    write_json,
)


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
    from tauten.service.tables import steps_table

    with progress_bar(f"steps of {robot}") as report:
        result = bench_steps(robot, refinements, factorisation, count, report)
    show_tables([steps_table(result)])
    show_mesh_error(robot_path(robot), load_robot(robot, refinements=refinements))
    write_json(result, json_file)


def sofa_meshes(
    data: Annotated[
        Path, typer.Option(envvar="TAUTEN_REFERENCE_DATA", help="Folder of the reference data.")
    ],
    count: Annotated[int, typer.Option("--steps", min=5, help="Steps to measure of each.")] = 200,
    json_file: Json = None,
    markdown: Markdown = None,
) -> None:
    """Steps on SOFA's meshes of trunk, diamond and finger, beside SOFA's published times."""
    from tauten.service.bench import bench_sofa_meshes
    from tauten.service.tables import (
        sofa_meshes_note,
        sofa_meshes_tables,
        write_sofa_meshes_tables,
    )

    for name in ("sofa_robots", "softrobots_finger.vtk"):
        if not (data / name).exists():
            raise typer.BadParameter(f"{data} has no {name}")
    with progress_bar("meshes of SOFA") as report:
        result = bench_sofa_meshes(data, count, report)
    show_tables(sofa_meshes_tables(result), 180)
    typer.echo(sofa_meshes_note(result))
    write_json(result, json_file)
    if markdown is not None:
        write_sofa_meshes_tables(result, markdown)


def gallery(
    robots: Annotated[
        list[str] | None, typer.Argument(help="Robots to measure; default: all of the gallery.")
    ] = None,
    count: Annotated[int, typer.Option("--steps", min=20, help="Inverse steps of each.")] = 300,
    json_file: Json = None,
    markdown: Markdown = None,
) -> None:
    """Sizes, inverse steps of full and reduced model, errors and campaigns of the gallery's robots.

    The errors of reduced models are those under loads that took no part in their training, and in motion.
    """
    from tauten.model.robots.gallery import ROBOTS
    from tauten.service.bench import bench_gallery
    from tauten.service.tables import gallery_table, loads_table, write_loads_table

    names = tuple(robots or ROBOTS)
    with progress_bar("gallery") as report:
        result = bench_gallery(names, count, report)
    show_tables([gallery_table(result), loads_table(result)], 200)
    write_json(result, json_file)
    if markdown is not None:
        write_loads_table(result, markdown)
