"""`tauten bench closed-loop`: controllers against the full-order robot, case by case."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from tauten.service.cli_bench import Json
from tauten.service.files import write_text

if TYPE_CHECKING:
    from tauten.service.closed_loop_run import Outcome


def closed_loop(
    robot: Annotated[str, typer.Argument(help="A shipped robot's name, or a robot file.")],
    json_file: Json = None,
    figures: Annotated[Path | None, typer.Option(help="Folder for a figure of each case.")] = None,
    seconds: Annotated[float, typer.Option(min=1.0, help="Of each case.")] = 4.0,
    seed: Annotated[int, typer.Option(help="Of the random walk.")] = 0,
) -> None:
    """Controllers with reduced, full, no contact against the full-order robot; Ctrl-C keeps what is done."""
    from tauten.service.bench_closed_loop import BenchSettings, bench_closed_loop
    from tauten.service.config import load_setup
    from tauten.service.stopping import stop_on_signals

    setup = load_setup(robot)
    if isinstance(setup.contact, str):
        raise typer.BadParameter(f"{robot} has no contact basis: tauten reduce {robot} makes one")
    settings = BenchSettings(seconds, seed, figures)
    with (
        stop_on_signals() as stop,
        Progress(console=Console(stderr=True), transient=True) as bar,
    ):
        task = bar.add_task("targets in reach", total=1.0)

        def progress(share: float, what: str) -> None:
            bar.update(task, advance=share, description=what)

        result = bench_closed_loop(setup.robot, setup.path, setup.contact, settings, stop, progress)
    show(result.outcomes)
    if not result.complete:
        Console().print("ended early: what is shown is what was done")
    if json_file is not None:
        write_text(json_file, json.dumps(asdict(result), indent=2) + "\n")


def show(outcomes: tuple[Outcome, ...]) -> None:
    """A table of all runs, a line a controller: open / closed loop."""
    table = Table(
        title="full-order robot against its target [mm], open / closed loop", pad_edge=False
    )
    for name in ("case", "contact"):
        table.add_column(name, no_wrap=True)
    for name in ("RMS", "at the end", "settled [s]", "latency p50 / p99 [ms]"):
        table.add_column(name, justify="right", no_wrap=True)
    lines: dict[tuple[str, str], list[Outcome]] = {}
    for one in outcomes:
        plant = "" if one.young_scale == 1.0 else f", E x {one.young_scale:g}"
        lines.setdefault((one.case + plant, one.contact), []).append(one)
    for (case, contact), pair in lines.items():
        settled = ("-" if one.settling_s is None else f"{one.settling_s:.2f}" for one in pair)
        table.add_row(
            case,
            contact,
            " / ".join(f"{one.rms_mm:.2f}" for one in pair),
            " / ".join(f"{one.end_mm:.2f}" for one in pair),
            " / ".join(settled),
            f"{pair[-1].latency_ms.p50:.2f} / {pair[-1].latency_ms.p99:.2f}",
        )
    Console().print(table)
