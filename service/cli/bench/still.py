"""`tauten bench still`: whether robots come to rest, at the best place, and never get stuck."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tauten.service.cli.terminal import Json, Markdown, Robots, progress_bar, show_result, writable


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
        typer.Option(callback=writable, help="Figure of the resting errors over the workspace."),
    ] = None,
) -> None:
    """Whether robots come to rest at constant targets, at the best place, and never get stuck.

    Ctrl-C keeps what is done.
    """
    from tauten.service.bench import StillSettings, bench_still
    from tauten.service.plots import draw_still
    from tauten.service.process import stop_on_signals
    from tauten.service.tables import still_page

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
    show_result(result, still_page(result), json_file, markdown, width=150)
    if figure is not None:
        draw_still(result, figure)
