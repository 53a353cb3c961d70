"""`tauten demo`, `tauten replay`, `tauten solve`: a run, its controller again, one of its problems again."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Annotated, Literal

import typer
from rich.console import Console
from rich.table import Table

from tauten.service.cli.entry import run as run_program
from tauten.service.cli.terminal import (
    Basis,
    ClosedLoop,
    DriveOption,
    Model,
    Period,
    StepsOption,
    WithKernels,
    YoungScale,
    progress_bar,
    writable,
    write_json,
)


def demo(
    robot: Annotated[str, typer.Argument(help="A shipped robot's name, or a file.")] = "finger",
    out: Annotated[
        Path | None, typer.Option(callback=writable, help="Folder for log, report and figure.")
    ] = None,
    seconds: Annotated[float, typer.Option(min=1.0, help="Duration of the targets.")] = 20.0,
    path: Annotated[str, typer.Option(help="As for `tauten stream`.")] = "reach",
    period: Period = None,
    fraction: Annotated[
        float, typer.Option(min=0.0, max=1.0, help="Share of the largest pull, for reach.")
    ] = 0.8,
    basis: Basis = None,
    model: Model = None,
    closed_loop: ClosedLoop = False,
    young_scale: YoungScale = 1.0,
    drive: DriveOption = "pull",
    steps: StepsOption = "own",
) -> None:
    """Run node, plant and stream as processes; write a log, a report and a figure.

    The folder is complete: with the robot's files, `replay` and `view` open its log anywhere. The exit code
    is 1 where no decision was OK.
    """
    from tauten.controller import Status
    from tauten.service.plant import FIGURE, DemoSettings, run_demo
    from tauten.service.process import stop_on_signals
    from tauten.service.replay import FOLLOWED, not_followed, table_rows

    folder = out or Path(f"tauten-demo-{datetime.now():%Y%m%d-%H%M%S}")
    writable(folder)
    console = Console(markup=False)
    settings = DemoSettings(
        robot,
        folder,
        seconds,
        path,
        period,
        fraction,
        basis,
        model,
        closed_loop,
        young_scale,
        drive,
        steps,
    )
    status = console.status("")

    def notify(said: str) -> None:
        status.update(WithKernels(said))
        status.start()  # a thread, which would be missing in the copies

    with stop_on_signals() as stop, ExitStack() as stack:
        stack.callback(status.stop)
        copied = run_program if sys.platform == "linux" else None
        done = run_demo(settings, stop, notify, copied)
    from tauten.service.plots import draw_run  # imports matplotlib, which nothing before waits for

    draw_run(done.run, done.actuators, folder / FIGURE)
    report = done.report
    table = Table("", f"{report.robot}, {report.duration_s:.1f} s", title="tauten demo")
    for row in table_rows(report):
        table.add_row(*row)
    console.print(table)
    if report.following < FOLLOWED * report.ticks:
        console.print(f"note: {not_followed(report)}", style="bold yellow")
    for note in done.notes:
        console.print(f"note: {note}", style="bold yellow")
    console.print(f"log, report and figure are in {folder}")
    if not report.statuses.get(Status.OK.name):
        raise typer.Exit(1)


def replay(
    log: Annotated[Path, typer.Argument(help="MCAP file of `serve --record` or `demo`.")],
    tolerance: Annotated[
        float, typer.Option(min=0.0, help="Accepted difference, as a share of each cable's range.")
    ] = 1e-4,
    against: Annotated[
        str | None, typer.Option(help="Robot to use instead of the recorded one: name or file.")
    ] = None,
    model: Annotated[
        Literal["full", "reduced"] | None,
        typer.Option(help="Model to use instead of the recorded one."),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(callback=writable, help="Folder for the differences: JSON, CSV, figure."),
    ] = None,
    recorded_paths: Annotated[
        bool,
        typer.Option(
            "--recorded-paths",
            help="Open the robot file and the basis at the paths that the log names, not only files "
            "beside the log. For logs of your own.",
        ),
    ] = False,
    problem: Annotated[
        Path | None,
        typer.Option(
            callback=writable,
            dir_okay=False,
            help="Only write the inverse problem of --tick to this file, for tauten solve.",
        ),
    ] = None,
    tick: Annotated[int, typer.Option(min=0, help="Number of the tick, for --problem.")] = 0,
    distance: Annotated[
        bool,
        typer.Option(
            "--distance",
            help="Also say what the distance of plant and model consists of, and how far the model is from "
            "converged time steps; takes several times the run.",
        ),
    ] = False,
) -> None:
    """Run the controller on a log's targets.

    Exit code 0: it decides the same; 1: it decides differently; 2: the log cannot be replayed.
    """
    from tauten.service.replay import replay as run
    from tauten.service.replay import write_problem, write_report

    if problem is not None:
        write_problem(log, tick, problem, recorded_paths)
        return
    result = run(log, tolerance, against, model, recorded_paths)
    table = Table("actuator", "position differs by", "effort differs by", title=str(log))
    for i, (name, kind) in enumerate(
        zip(result.actuators.names, result.actuators.kinds, strict=True)
    ):
        table.add_row(
            name, kind.position.text(result.position[i]), kind.effort.text(result.effort[i])
        )
    console = Console(markup=False)
    console.print(table)
    verdict = "the same" if result.same else "different"
    console.print(
        f"{verdict}: {result.ticks} ticks, at most {result.fraction:.2g} of the range apart "
        f"(tick {result.worst_tick}, tolerance {tolerance:g}), {result.statuses} other statuses; "
        f"{result.speed:.1f} times as fast as the run"
    )
    console.print(f"mesh error: {result.mesh_error}")
    for note in result.notes:
        console.print(f"note: {note}")
    if report is not None:
        from tauten.service.plots import draw_replay  # imports matplotlib

        write_report(result, str(log), report)
        draw_replay(result, str(log), report / "replay.png")
    if distance:
        _show_distances(log, recorded_paths, report, console)
    raise typer.Exit(0 if result.same else 1)


def _show_distances(log: Path, recorded_paths: bool, report: Path | None, console: Console) -> None:
    """What the distance of plant and model consists of: a table, and files in a folder."""
    from tauten.service.replay import distance_rows, measure_distances

    with progress_bar("simulating") as bar:
        found = measure_distances(log, recorded_paths, bar)
    table = Table("first effector", f"{found.robot}, plant: {found.steps}", title="plant and model")
    for row in distance_rows(found):
        table.add_row(*row)
    console.print(table)
    if report is not None:
        from tauten.service.plots import draw_distances  # imports matplotlib

        shares = {name: asdict(share) for name, share in found.shares().items()}
        write_json(shares, report / "distance.json")
        draw_distances(found, report / "distance.png")


def solve(
    file: Annotated[Path, typer.Argument(help="A problem, written by `write_qpcc`.")],
    solver: Annotated[str, typer.Option(help="QP library.")] = "daqp",
    max_pivots: Annotated[int, typer.Option(min=0, help="QPs at most.")] = 300,
    cold: Annotated[bool, typer.Option("--cold", help="Leave out the start in the file.")] = False,
) -> None:
    """Solve a QPCC from a file; print solution, certificate and status. Exit code 1: no usable point."""
    from tauten.controller.qpcc import QpccSettings, read_qpcc, solve_qpcc

    try:
        problem, start = read_qpcc(file)
        settings = QpccSettings(solver, max_pivots)
        solution = solve_qpcc(problem, None if cold else start, settings)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    found, console = solution.certificate, Console(highlight=False, soft_wrap=True, markup=False)
    console.print(f"status           {solution.status.name}: {solution.status.value}")
    if solution.conflict:
        console.print(f"conflict         {', '.join(solution.conflict)}")
    console.print(f"objective        {solution.objective:.12g}")
    console.print(f"primal           {found.primal:.1e}")
    console.print(f"complementarity  {found.complementarity:.1e}")
    console.print(f"stationarity     {found.stationarity:.1e}")
    console.print(f"QPs              {solution.pivots}")
    for name, values in (("lam_a", solution.lam_a), ("beta", solution.beta)):
        console.print(f"{name:16} {' '.join(f'{value:.6g}' for value in values)}")
    if not solution.status.usable:
        raise typer.Exit(1)
