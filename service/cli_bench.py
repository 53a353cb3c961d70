"""`tauten bench`: benchmarks of the rooms, each with a table and, on request, JSON."""

from __future__ import annotations

import typer

bench = typer.Typer(help="Measure.", no_args_is_help=True)
