"""`tauten bench`: benchmarks, each with a table and optionally a JSON file."""

from __future__ import annotations

import typer

from tauten.service.cli.bench.closed_loop import closed_loop
from tauten.service.cli.bench.contact import contact_basis, finger, manipulator
from tauten.service.cli.bench.mechanics import elements, energy, equilibria, still
from tauten.service.cli.bench.node import node
from tauten.service.cli.bench.qpcc import qpcc
from tauten.service.cli.bench.steps import gallery, sofa_meshes, steps
from tauten.service.cli.bench.view import view

bench = typer.Typer(help="Benchmarks; run them on an otherwise idle machine.", no_args_is_help=True)
_COMMANDS = (
    *(finger, manipulator, gallery, steps, sofa_meshes, qpcc, contact_basis),
    *(closed_loop, elements, energy, equilibria, still, node, view),
)
for _command in _COMMANDS:
    bench.command()(_command)
