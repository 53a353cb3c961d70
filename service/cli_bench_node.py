"""`tauten bench node`: a served robot's ticks, and what the machine alone would miss."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from tauten.service.cli_bench import Json
from tauten.service.cli_options import Model
from tauten.service.files import write_text


def node(
    robot: Annotated[str, typer.Argument(help="A shipped robot's name, or a robot file.")],
    model: Model = None,
    rate: Annotated[
        list[float] | None,
        typer.Option(min=0.1, help="Control rate [Hz], or several; default: the robot file's."),
    ] = None,
    seconds: Annotated[float, typer.Option(min=2.0, help="Of targets.")] = 60.0,
    targets: Annotated[float, typer.Option(min=0.1, help="Targets a second.")] = 50.0,
    priority: Annotated[
        int | None, typer.Option(min=1, max=99, help="As for `tauten serve`.")
    ] = None,
    cpus: Annotated[list[int] | None, typer.Option(help="As for `tauten serve`.")] = None,
    json_file: Json = None,
    markdown: Annotated[Path | None, typer.Option(help="Page to put the table into.")] = None,
) -> None:
    """Serve a robot, stream targets, and show deadlines, step, overhead and latency of its ticks.

    Ctrl-C keeps what is done.
    """
    from tauten.service.bench_node import NodeBenchSettings, bench_node
    from tauten.service.config import load_setup
    from tauten.service.node_tables import table, write_markdown
    from tauten.service.stopping import stop_on_signals

    options: list[str] = []
    if model is not None:
        options += ["--model", model]
    if priority is not None:
        options += ["--priority", str(priority)]
    for cpu in cpus or []:
        options += ["--cpus", str(cpu)]
    settings = NodeBenchSettings(seconds, targets, tuple(options))
    rates: list[float | None] = [*rate] if rate else [None]
    results = []
    with stop_on_signals() as stop, Console(stderr=True).status(robot) as status:
        for one in rates:
            setup = load_setup(robot, rate=one, model=model)
            if not stop.requested:
                results.append(bench_node(setup, robot, settings, stop, status.update))
    Console().print(table(results).rich())
    if json_file is not None:
        write_text(json_file, json.dumps([asdict(result) for result in results], indent=2) + "\n")
    if markdown is not None:
        write_markdown(results, markdown)
