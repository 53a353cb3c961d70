"""`tauten bench finger`, `manipulator` and `contact-basis`: contact, and what its reduction changes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.console import Console

from tauten.service.cli.bench.basis import basis_of
from tauten.service.cli.terminal import (
    Json,
    Markdown,
    progress_bar,
    show_mesh_error,
    show_tables,
    write_json,
)

if TYPE_CHECKING:
    from tauten.reduction import ContactBasis


def finger(
    json_file: Json = None,
    robot: Annotated[str, typer.Option(help="Robot to measure.")] = "finger",
    basis: Annotated[
        str | None, typer.Option(help="Contact basis to use instead of the robot file's.")
    ] = None,
    seconds: Annotated[float, typer.Option(min=1.0, help="Duration of the path.")] = 12.0,
    pulls: Annotated[int, typer.Option(min=2, help="Number of equilibria to compare.")] = 201,
    model: Annotated[
        Literal["full", "reduced"], typer.Option(help="Reduce contact only, or contact and state.")
    ] = "full",
    refinements: Annotated[
        int, typer.Option(min=0, max=2, help="Refinements of the mesh, for the reduced model.")
    ] = 0,
    snapshots: Annotated[
        Path | None,
        typer.Option(help="Folder of the reduced model's campaigns; default: ROBOT-bench."),
    ] = None,
    markdown: Annotated[
        Path | None, typer.Option(help="Page to put the reduced model's tables into.")
    ] = None,
) -> None:
    """Stage times of a control step with contact none, full, reduced; tips of reduced against full.

    With --model reduced: number of state modes and sampled elements against errors and step times.
    """
    from tauten.service.bench import bench_control
    from tauten.service.setup import load_setup
    from tauten.service.tables import control_table, tip_sentences

    setup = load_setup(robot, basis=basis, model="full")
    modes = basis_of(setup, robot)
    if model == "reduced":
        folder = snapshots or Path(f"{setup.robot.name}-bench")
        _reduced(robot, modes, folder, refinements, seconds, json_file, markdown)
        return
    with progress_bar(f"control steps of {robot}") as report:
        result = bench_control(setup.robot, modes, setup.controller, seconds, pulls, report)
    show_tables([control_table(result)])
    for sentence in tip_sentences(result):
        Console().print(sentence)
    show_mesh_error(setup.path, setup.robot)
    write_json(result, json_file)


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
    from tauten.model.load import robot_path
    from tauten.service.bench import ArmBenchSettings, bench_manipulator, parse_ks
    from tauten.service.plots import Side, draw_comparison, draw_posture_errors
    from tauten.service.tables import arm_tables, sentences, write_arm_tables

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
    console = Console(width=200)
    for table in arm_tables(result):
        console.print(table.rich())
    for sentence in sentences(result):
        console.print(sentence)
    show_mesh_error(robot_path("manipulator"), bent.robot)
    write_json(result, json_file)
    if markdown is not None:
        write_arm_tables(result, markdown)


def contact_basis(
    robot: Annotated[str, typer.Argument(help="A shipped robot's name, or a robot file.")],
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
    from tauten.reduction.campaign import ramp, run_campaign
    from tauten.service.bench import ContactBasisInputs, bench_contact_basis
    from tauten.service.plots import draw_contact_basis
    from tauten.service.process import stop_on_signals
    from tauten.service.setup import load_setup
    from tauten.service.tables import (
        certificate,
        contact_basis_tables,
        write_contact_basis_tables,
    )

    setup = load_setup(robot, model="full")
    basis = basis_of(setup, robot)
    folder = snapshots or Path(f"{setup.robot.name}-snapshots")
    found = run_campaign(setup.robot, ramp(setup.robot), folder)
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
    show_tables(contact_basis_tables(result))
    Console().print(certificate(result))
    show_mesh_error(setup.path, setup.robot)
    write_json(result, json_file)
    if markdown is not None:
        write_contact_basis_tables(result, markdown)
    if figure is not None:
        draw_contact_basis(result, figure)


def _reduced(
    robot: str,
    basis: ContactBasis,
    folder: Path,
    refinements: int,
    seconds: float,
    json_file: Path | None,
    markdown: Path | None,
) -> None:
    """The reduced model's benchmark."""
    from tauten.service.bench import bench_reduced
    from tauten.service.tables import reduced_tables, write_reduced_tables

    with progress_bar("reduced models") as report:
        result = bench_reduced(robot, basis, folder, refinements, seconds, report)
    show_tables(reduced_tables(result))
    write_json(result, json_file)
    if markdown is not None:
        write_reduced_tables(result, markdown)
