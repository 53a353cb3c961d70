"""`tauten bench`: benchmarks, each with a table and optionally a JSON file."""

from __future__ import annotations

import typer

from tauten.service.cli.bench.closed_loop import closed_loop
from tauten.service.cli.bench.node import node
from tauten.service.cli.bench.reduced import reduced
from tauten.service.cli.bench.steps import steps
from tauten.service.cli.bench.still import still

bench = typer.Typer(help="Benchmarks; run them on an otherwise idle machine.", no_args_is_help=True)
for _command in (steps, node, closed_loop, reduced, still):
    bench.command()(_command)
