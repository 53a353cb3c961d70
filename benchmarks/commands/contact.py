"""Contact in `python -m benchmarks`: `finger`, `manipulator`, `contact-basis`, distances to `obstacles`."""

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
    show_mesh_error,
    show_result,
)


def finger(
    json_file: Json = None,
    robot: Annotated[str, typer.Option(help="Robot to measure.")] = "finger",
    basis: Annotated[
        str | None, typer.Option(help="Contact basis to use instead of the robot file's.")
    ] = None,
    seconds: Annotated[float, typer.Option(min=1.0, help="Duration of the path.")] = 12.0,
    pulls: Annotated[int, typer.Option(min=2, help="Number of equilibria to compare.")] = 201,
) -> None:
    """Stage times of a control step with contact none, full, reduced; tips of reduced against full."""
    from benchmarks.steps import bench_control
    from benchmarks.tables import control_page
    from tauten.service.setup import load_setup

    setup = load_setup(robot, basis=basis, model="full")
    modes = basis_of(setup, robot)
    with progress_bar(f"control steps of {robot}") as report:
        result = bench_control(setup.robot, modes, setup.controller, seconds, pulls, report)
    show_result(result, control_page(result), json_file)
    show_mesh_error(setup.path, setup.robot)


def manipulator(
    json_file: Json = None,
    markdown: Markdown = None,
    snapshots: Annotated[
        Path, typer.Option(help="Folder of the campaigns; results in it are used again.")
    ] = Path("manipulator-bench"),
    figures: Annotated[Path, typer.Option(help="Folder of the pictures.")] = Path("figures"),
    modes: Annotated[str, typer.Option(help="Numbers of modes to measure the error at.")] = (
        "5,10,15,23,30,40,60"
    ),
) -> None:
    """Steps per second straight and bent, full and reduced; effect of contact; error over modes."""
    from benchmarks.manipulator import ArmBenchSettings, bench_manipulator, parse_ks
    from benchmarks.plots import draw_posture_errors
    from benchmarks.tables import arm_page
    from tauten.model.load import robot_path
    from tauten.service.plots import Side, draw_comparison

    try:
        settings = ArmBenchSettings(snapshots, parse_ks(modes))
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    with progress_bar("manipulator") as report:
        result, bent = bench_manipulator(settings, report)
    figures.mkdir(parents=True, exist_ok=True)
    picture = figures / "manipulator-contact.png"
    draw_comparison(bent.robot, bent.touching, bent.passing, Side(), picture)
    draw_posture_errors(result.errors, figures / "manipulator-errors.png")
    show_result(result, arm_page(result), json_file, markdown)
    show_mesh_error(robot_path("manipulator"), bent.robot)


def contact_basis(
    robot: RobotName,
    json_file: Json = None,
    markdown: Markdown = None,
    figure: Annotated[Path | None, typer.Option(help="Picture to draw.")] = None,
    snapshots: Annotated[
        Path | None, typer.Option(help="Folder of campaigns; default: ROBOT-snapshots.")
    ] = None,
    equilibria: Annotated[
        int, typer.Option(min=2, help="Number of equilibria on the training path.")
    ] = 20,
    steps: Annotated[int, typer.Option(min=2, help="Number of steps of a held-out path.")] = 16,
) -> None:
    """Errors of contact bases on and off their training path; certificate, LCP. Ctrl-C keeps results."""
    from benchmarks.contact_basis import ContactBasisInputs, bench_contact_basis
    from benchmarks.plots import draw_contact_basis
    from benchmarks.tables import contact_basis_page
    from tauten.reduction.campaign import ramp, run_campaign
    from tauten.service.process import stop_on_signals
    from tauten.service.setup import load_setup

    setup = load_setup(robot, model="full")
    basis = basis_of(setup, robot)
    folder = snapshots or Path(f"{setup.robot.name}-snapshots")
    with progress_bar("snapshots") as report:
        found = run_campaign(setup.robot, ramp(setup.robot), folder, report=report)
    inputs = ContactBasisInputs(
        setup.robot,
        basis,
        found.select(found.converged),
        folder,
        equilibria,
        steps,
        controller=setup.controller,
    )
    with stop_on_signals() as stop, progress_bar("") as report:
        result = bench_contact_basis(inputs, stop, report)
    show_result(result, contact_basis_page(result), json_file, markdown)
    show_mesh_error(setup.path, setup.robot)
    if figure is not None:
        draw_contact_basis(result, figure)


def obstacles(json_file: Json = None, markdown: Markdown = None) -> None:
    """Times of the distances of 2,000 contact candidates to an obstacle of 10,000 triangles."""
    from benchmarks.steps import bench_mesh_distance
    from benchmarks.tables import obstacles_page

    with progress_bar("distances to a mesh") as report:
        result = bench_mesh_distance(report)
    show_result(result, obstacles_page(result), json_file, markdown)
