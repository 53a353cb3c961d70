"""`tauten bench`: benchmarks, each with a table and optionally a JSON file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from rich.console import Console
from rich.text import Text
from typer.core import TyperGroup

from tauten.service.cli.terminal import (
    Json,
    Markdown,
    Model,
    RobotName,
    basis_of,
    progress_bar,
    show_mesh_error,
    show_result,
    writable,
    write_json,
)


def steps(
    robot: RobotName,
    refinements: Annotated[int, typer.Option(min=0, max=3, help="Uniform refinements.")] = 0,
    factorisation: Annotated[
        Literal["auto", "pardiso", "cholmod", "superlu"],
        typer.Option(help="Library for the sparse linear systems."),
    ] = "auto",
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


def node(
    robot: RobotName,
    model: Model = None,
    rate: Annotated[
        list[float] | None,
        typer.Option(min=0.1, help="Control rate [Hz], or several; default: the robot file's."),
    ] = None,
    seconds: Annotated[float, typer.Option(min=2.0, help="Duration of the targets.")] = 60.0,
    targets: Annotated[float, typer.Option(min=0.1, help="Targets a second.")] = 50.0,
    priority: Annotated[
        int | None, typer.Option(min=1, max=99, help="As for `tauten serve`.")
    ] = None,
    cpus: Annotated[list[int] | None, typer.Option(help="As for `tauten serve`.")] = None,
    viewer: Annotated[
        bool, typer.Option("--viewer", help="Also show the robot with `tauten view` meanwhile.")
    ] = False,
    json_file: Json = None,
    markdown: Markdown = None,
) -> None:
    """Serve a robot, stream targets, and show deadlines, step, overhead and latency of its ticks.

    Ctrl-C keeps finished results.
    """
    from tauten.service.bench import NodeBenchSettings, bench_node
    from tauten.service.process import RealtimeSettings, stop_on_signals
    from tauten.service.setup import load_setup
    from tauten.service.tables import node_page

    options: list[str] = []
    if model is not None:
        options += ["--model", model]
    if priority is not None:
        options += ["--priority", str(priority)]
    for cpu in cpus or []:
        options += ["--cpus", str(cpu)]
    realtime = RealtimeSettings(priority, tuple(cpus or ()))
    rates: list[float | None] = [*rate] if rate else [None]
    results = []
    with (
        stop_on_signals() as stop,
        Console(stderr=True, markup=False).status(Text(robot)) as status,
    ):
        for one in rates:
            chosen = () if one is None else ("--rate", repr(one))
            settings = NodeBenchSettings(seconds, targets, (*options, *chosen), realtime, viewer)
            setup = load_setup(robot, rate=one, model=model)
            if stop.requested or not (
                found := bench_node(setup, robot, settings, stop, status.update)
            ):
                break
            results.append(found)
            write_json(results, json_file)
    if not results:  # stopped before there were any
        raise typer.Exit(130)
    show_result(results, node_page(results), json_file, markdown)
    if stop.requested:
        Console(markup=False).print("stopped early: the table has what was measured until then")


def closed_loop(
    robot: RobotName,
    json_file: Json = None,
    markdown: Markdown = None,
    periods: Annotated[
        list[float] | None,
        typer.Option("--period", min=1.0, help="Of a path in reach, in s; by default 10 and 6."),
    ] = None,
) -> None:
    """A controller against the full-order robot, which has time steps of its own; Ctrl-C keeps finished runs.

    It follows a path in reach with its one effector, and the distance of model and plant is divided into its
    shares.
    """
    from tauten.service.bench import bench_closed_loop
    from tauten.service.process import stop_on_signals
    from tauten.service.setup import load_setup
    from tauten.service.tables import closed_loop_page

    setup, times, result = load_setup(robot), tuple(periods or (10.0, 6.0)), None
    with stop_on_signals() as stop, progress_bar("targets in reach") as report:
        result = bench_closed_loop(setup, times, stop, report)
    if result is None:  # stopped before a run was done
        raise typer.Exit(130)
    show_result(result, closed_loop_page(result), json_file, markdown)
    if not result.complete:
        Console(markup=False).print("stopped early: the table has the runs that were done")


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


class _Benchmarks(TyperGroup):
    """The benchmarks for users; those for the makers of tauten are outside the package."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command of a name; an unknown one is an error that says where other benchmarks are."""
        name = args[0]
        if self.get_command(ctx, name) is None:
            ctx.fail(
                f"found {name!r}, allowed are {', '.join(self.list_commands(ctx))}; other benchmarks run "
                f"in a clone of the repository: python -m benchmarks {name}"
            )
        return super().resolve_command(ctx, args)


bench = typer.Typer(
    cls=_Benchmarks,
    help="Benchmarks; run them on an otherwise idle machine. More of them run in a "
    "clone of the repository: python -m benchmarks",
    no_args_is_help=True,
)
for _command in (steps, node, closed_loop, reduced):
    bench.command()(_command)
