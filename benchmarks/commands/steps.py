"""`python -m benchmarks sofa-meshes`, `reduced-meshes`, `gallery`, `load-errors`: steps, and errors."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tauten.service.cli.terminal import (
    Json,
    Markdown,
    Model,
    RobotName,
    basis_of,
    progress_bar,
    show_result,
)


def sofa_meshes(
    data: Annotated[
        Path, typer.Option(envvar="TAUTEN_REFERENCE_DATA", help="Folder of the reference data.")
    ],
    count: Annotated[int, typer.Option("--steps", min=5, help="Steps to measure of each.")] = 200,
    json_file: Json = None,
    markdown: Markdown = None,
) -> None:
    """Steps on SOFA's meshes of trunk, diamond and finger, beside SOFA's published times."""
    from benchmarks.steps import bench_sofa_meshes
    from benchmarks.tables import sofa_meshes_page

    for name in ("sofa_robots", "softrobots_finger.vtk"):
        if not (data / name).exists():
            raise typer.BadParameter(f"{data} has no {name}")
    with progress_bar("meshes of SOFA") as report:
        result = bench_sofa_meshes(data, count, report)
    show_result(result, sofa_meshes_page(result), json_file, markdown)


def gallery(
    robots: Annotated[
        list[str] | None, typer.Argument(help="Robots to measure; default: all of the gallery.")
    ] = None,
    count: Annotated[int, typer.Option("--steps", min=20, help="Inverse steps of each.")] = 300,
    model: Model = None,
    json_file: Json = None,
    markdown: Markdown = None,
) -> None:
    """Sizes, inverse steps of full and reduced model, and campaigns of the gallery's robots."""
    from benchmarks.robots.gallery import ROBOTS
    from benchmarks.steps import bench_gallery
    from benchmarks.tables import gallery_page

    names = tuple(robots or ROBOTS)
    with progress_bar("gallery") as report:
        result = bench_gallery(names, count, report, model)
    show_result(result, gallery_page(result), json_file, markdown)


def load_errors(
    robots: Annotated[
        list[str], typer.Argument(help="Robots with a reduced model, names or files.")
    ],
    json_file: Json = None,
    markdown: Markdown = None,
) -> None:
    """Reduced against full models under loads that took no part in their training, and in motion."""
    from benchmarks.steps import bench_load_errors
    from benchmarks.tables import load_errors_page

    with progress_bar("load errors") as report:
        result = bench_load_errors(tuple(robots), report)
    show_result(result, load_errors_page(result), json_file, markdown)


def reduced_meshes(
    robot: RobotName,
    json_file: Json = None,
    markdown: Markdown = None,
    seconds: Annotated[float, typer.Option(min=1.0, help="Duration of the path.")] = 12.0,
    refinements: Annotated[
        int,
        typer.Option(min=0, max=2, help="Refinements of the mesh, each with models of its own."),
    ] = 0,
    snapshots: Annotated[
        Path | None,
        typer.Option(help="Folder of the reduced models' campaigns; default: ROBOT-bench."),
    ] = None,
) -> None:
    """Steps of full and reduced models on a mesh and its refinements, stage by stage."""
    from benchmarks.steps import bench_reduced_meshes
    from benchmarks.tables import reduced_meshes_page
    from tauten.service.setup import load_setup

    setup = load_setup(robot, model="full")
    folder, modes = snapshots or Path(f"{setup.robot.name}-bench"), basis_of(setup, robot)
    with progress_bar("reduced models") as report:
        result = bench_reduced_meshes(robot, modes, folder, refinements, seconds, report)
    show_result(result, reduced_meshes_page(result), json_file, markdown)
