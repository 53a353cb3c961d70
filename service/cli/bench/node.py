"""`tauten bench node`: ticks of a served robot, and deadlines that an idle loop misses on this machine."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from tauten.service.cli.terminal import Json, Markdown, Model, RobotName, show_result, write_json


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
            if markdown is not None:
                node_page(results).put_into(markdown)
    if results:
        show_result(results, node_page(results), json_file, markdown)
