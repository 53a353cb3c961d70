"""`python -m benchmarks closed-loop`, `contact-loop` and `still`: controllers against robots."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tauten.service.cli.terminal import (
    Json,
    Markdown,
    RobotName,
    Robots,
    basis_of,
    drawable,
    progress_bar,
    show_mesh_error,
    show_result,
)


def closed_loop(
    robot: RobotName,
    json_file: Json = None,
    markdown: Markdown = None,
    figures: Annotated[Path | None, typer.Option(help="Folder for a figure of each case.")] = None,
    seconds: Annotated[float, typer.Option(min=1.0, help="Duration of each case.")] = 4.0,
    seed: Annotated[int, typer.Option(help="Seed of the random walk.")] = 0,
) -> None:
    """Controllers with reduced, full and no contact, in open and closed loop. Ctrl-C keeps finished runs."""
    from benchmarks.control import bench_cases
    from benchmarks.plots import draw_case
    from benchmarks.tables import closed_loop_page
    from tauten.service.process import stop_on_signals
    from tauten.service.setup import load_setup

    setup = load_setup(robot)
    basis_of(setup, robot)
    with stop_on_signals() as stop, progress_bar("targets in reach") as report:
        result, runs = bench_cases(setup, seconds, seed, stop, report)
    show_result(result, closed_loop_page(result), json_file, markdown)
    show_mesh_error(setup.path, setup.robot)
    if figures is not None:
        figures.mkdir(parents=True, exist_ok=True)
        for one in runs:
            draw_case(one, setup.robot.h, figures / f"{one.name}.png")


def contact_loop(json_file: Json = None, markdown: Markdown = None) -> None:
    """A tip along a wall with 1 N, and a cube that is lifted; Ctrl-C keeps finished runs."""
    from benchmarks.control import bench_contact
    from benchmarks.tables import contact_loop_page
    from tauten.service.process import stop_on_signals

    with stop_on_signals() as stop, progress_bar("contact") as report:
        result = bench_contact(stop, report)
    show_result(result, contact_loop_page(result), json_file, markdown)


def still(
    json_file: Json = None,
    robot: Robots = None,
    model: Annotated[
        list[str] | None, typer.Option(help="full or reduced (default); may be repeated.")
    ] = None,
    targets: Annotated[int, typer.Option(min=1, help="Random targets of each group of runs.")] = 10,
    orders: Annotated[
        int, typer.Option(min=0, help="Random locks, holds, unlocks and targets of each robot.")
    ] = 400,
    seconds: Annotated[float, typer.Option(min=1.0, help="Longest run in open loop.")] = 8.0,
    minutes: Annotated[
        float,
        typer.Option(min=0.0, help="For the targets of each robot and model; fewer after it."),
    ] = 10.0,
    seed: Annotated[int, typer.Option(help="Of targets and orders.")] = 0,
    markdown: Markdown = None,
    figure: Annotated[
        Path | None,
        typer.Option(callback=drawable, help="Figure of the resting errors over the workspace."),
    ] = None,
) -> None:
    """Whether robots come to rest at constant targets, at the best place, and never get stuck.

    Ctrl-C keeps what is done.
    """
    from benchmarks.control import StillSettings, bench_still
    from benchmarks.plots import draw_still
    from benchmarks.tables import still_page
    from tauten.service.process import stop_on_signals

    for name in model or ():
        if name not in ("full", "reduced"):
            raise typer.BadParameter(f"--model {name}: allowed are full and reduced")
    default = StillSettings()
    chosen = StillSettings(
        robots=tuple(robot or default.robots),
        models=tuple(model or default.models),  # type: ignore[arg-type]
        targets=targets,
        orders=orders,
        seconds=seconds,
        seed=seed,
        minutes=minutes,
    )
    with stop_on_signals() as stop, progress_bar("still") as report:
        result = bench_still(chosen, stop, report)
    show_result(result, still_page(result), json_file, markdown)
    if figure is not None:
        draw_still(result, figure)
