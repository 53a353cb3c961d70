"""`tauten bench`: benchmarks, each with a table and optionally a JSON file."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from tauten.service.process import write_text

if TYPE_CHECKING:
    from tauten.model import Robot
    from tauten.reduction import ContactBasis
    from tauten.service.bench import ControlBench, StepBench
    from tauten.service.replay import Spread

bench = typer.Typer(help="Benchmarks; run them on an otherwise idle machine.", no_args_is_help=True)

R = TypeVar("R")
Json = Annotated[Path | None, typer.Option("--json", help="Write the numbers to this file.")]


@bench.command()
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

    setup = load_setup(robot, basis=basis, model="full")
    if isinstance(setup.contact, str):
        raise typer.BadParameter(f"{robot} has no contact basis: tauten reduce {robot} makes one")
    modes = setup.contact
    if model == "reduced":
        folder = snapshots or Path(f"{setup.robot.name}-bench")
        _reduced(robot, modes, folder, refinements, seconds, json_file, markdown)
        return
    result = _with_bar(
        f"control steps of {robot}",
        lambda progress: bench_control(
            setup.robot, modes, setup.controller, seconds, pulls, progress
        ),
    )
    _show_control(result)
    show_mesh_error(setup.path, setup.robot)
    _write(result, json_file)


@bench.command()
def manipulator(
    json_file: Json = None,
    markdown: Annotated[Path | None, typer.Option(help="Page to put the tables into.")] = None,
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
    result, bent = _with_bar("manipulator", lambda progress: bench_manipulator(settings, progress))
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
    _write(result, json_file)
    if markdown is not None:
        write_arm_tables(result, markdown)


@bench.command()
def gallery(
    robots: Annotated[
        list[str] | None, typer.Argument(help="Robots to measure; default: all of the gallery.")
    ] = None,
    count: Annotated[int, typer.Option("--steps", min=20, help="Inverse steps of each.")] = 300,
    json_file: Json = None,
) -> None:
    """Sizes, inverse steps of full and reduced model, errors and campaigns of the gallery's robots."""
    from tauten.model.robots.gallery import ROBOTS
    from tauten.service.bench import bench_gallery
    from tauten.service.tables import gallery_table

    names = tuple(robots or ROBOTS)
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("gallery", total=1.0)
        result = bench_gallery(
            names, count, lambda share, what: bar.update(task, advance=share, description=what)
        )
    Console(width=200).print(gallery_table(result).rich())
    _write(result, json_file)


@bench.command()
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

    result = _with_bar(
        f"steps of {robot}",
        lambda progress: bench_steps(robot, refinements, factorisation, count, progress),
    )
    _show_steps(result)
    show_mesh_error(robot_path(robot), load_robot(robot, refinements=refinements))
    _write(result, json_file)


@bench.command()
def qpcc(
    json_file: Json = None,
    markdown: Annotated[Path | None, typer.Option(help="Page to put the tables into.")] = None,
    recorded: Annotated[Path | None, typer.Option(help="Folder of recorded problems.")] = None,
    published: Annotated[
        Path | None, typer.Option(help="Folder of published problems, with a problems.csv.")
    ] = None,
) -> None:
    """Times of QPCCs by size, start and QP library; distance of their solutions from the optimum."""
    from tauten.service.bench.qpcc import bench_qpcc
    from tauten.service.tables import qpcc_tables, write_qpcc_tables

    shipped = Path(__file__).resolve().parents[2] / "tests" / "reference" / "qpcc"
    folder: Path | None = recorded or shipped
    if recorded is None and not shipped.is_dir():
        folder = None  # an installed package does not contain them
    if folder is not None and not list(folder.glob("*.npz")):
        raise typer.BadParameter(f"{folder} has no recorded problems, files that end in .npz")
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("problems", total=1.0)
        result = bench_qpcc(
            folder, published, lambda share, what: bar.update(task, advance=share, description=what)
        )
    for table in qpcc_tables(result):
        Console().print(table.rich())
    _write(result, json_file)
    if markdown is not None:
        write_qpcc_tables(result, markdown)


@bench.command()
def contact_basis(
    robot: Annotated[str, typer.Argument(help="A shipped robot's name, or a robot file.")],
    json_file: Json = None,
    markdown: Annotated[Path | None, typer.Option(help="Page to put the tables into.")] = None,
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

    setup = load_setup(robot)
    if isinstance(setup.contact, str):
        raise typer.BadParameter(f"{robot} has no contact basis: tauten reduce {robot} makes one")
    folder = snapshots or Path(f"{setup.robot.name}-snapshots")
    found = run_campaign(setup.robot, ramp(setup.robot), folder)
    inputs = ContactBasisInputs(
        setup.robot,
        setup.contact,
        found.select(found.converged),
        folder,
        equilibria,
        steps,
        controller=setup.controller,
    )
    with stop_on_signals() as stop, Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=1.0)
        result = bench_contact_basis(
            inputs, stop, lambda share, what: bar.update(task, advance=share, description=what)
        )
    for table in contact_basis_tables(result):
        Console().print(table.rich())
    Console().print(certificate(result))
    show_mesh_error(setup.path, setup.robot)
    _write(result, json_file)
    if markdown is not None:
        write_contact_basis_tables(result, markdown)
    if figure is not None:
        draw_contact_basis(result, figure)


def show_mesh_error(path: Path, robot: Robot) -> None:
    """Print the error of a robot's mesh, as far as it is known.

    Args:
        path: of the robot file.
        robot: made from it.
    """
    from tauten.service.check import mesh_error_text

    Console().print(f"mesh error: {mesh_error_text(path, robot.digest)}")


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

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reduced models", total=1.0)
        result = bench_reduced(
            robot, basis, folder, refinements, seconds,
            lambda share, what: bar.update(task, advance=share, description=what),
        )  # fmt: skip
    for table in reduced_tables(result):
        Console().print(table.rich())
    _write(result, json_file)
    if markdown is not None:
        write_reduced_tables(result, markdown)


def _with_bar(text: str, work: Callable[[Callable[[float], None]], R]) -> R:
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(text, total=1.0)
        return work(lambda share: bar.advance(task, share))


def _write(result: Any, path: Path | None) -> None:
    """The numbers as JSON, whole or not at all."""
    if path is not None:
        write_text(path, json.dumps(asdict(result), indent=2) + "\n")


def _ms(value: Spread) -> str:
    return "-" if value.p50 is None else f"{value.p50:.2f} / {value.p99:.2f}"


def _show_control(result: ControlBench) -> None:
    sizes = result.sizes
    table = Table(
        title=f"{result.robot}: {sizes.nodes} nodes, {sizes.elements} elements, "
        f"{sizes.candidates} candidates; {result.factorisation}; median / p99 in ms"
    )
    table.add_column("stage")
    for times in result.control:
        table.add_column(times.contact, justify="right")
    for stage in (*result.control[0].stages_ms, *result.control[0].whole_ms):
        spreads = [{**times.stages_ms, **times.whole_ms}[stage] for times in result.control]
        table.add_row(stage, *(_ms(value) for value in spreads))
    table.add_row("tip error [mm]", *(_ms(times.tip_error_mm) for times in result.control))
    table.add_row("status", *(", ".join(times.statuses) for times in result.control))
    console = Console()
    console.print(table)
    for error in result.tip_error:
        kind = "with" if error.enriched else "without"
        console.print(
            f"tip of reduced against pointwise contact, {kind} enrichment: mean {error.mean_mm:.3f}, "
            f"max {error.max_mm:.3f} mm at {error.pulls} pulls; deepest gap {error.deepest_gap_mm:.3f} mm"
        )


def _show_steps(result: StepBench) -> None:
    table = Table(title=f"{result.robot}: one step without contact, median / p99 in ms")
    for column in ("nodes", "elements", "factorisation", "forward", "inverse"):
        table.add_column(column, justify="right")
    for mesh in result.meshes:
        sizes = (str(mesh.sizes.nodes), str(mesh.sizes.elements))
        table.add_row(*sizes, mesh.factorisation, _ms(mesh.forward_ms), _ms(mesh.inverse_ms))
    Console().print(table)
