"""`python -m benchmarks`: each benchmark with a table and optionally a JSON file."""

from __future__ import annotations

import typer

from benchmarks.commands.contact import contact_basis, finger, manipulator, obstacles
from benchmarks.commands.control import closed_loop, contact_loop, still
from benchmarks.commands.friction import friction, friction_inverse, friction_modes
from benchmarks.commands.kernels import check_kernels, first_hour, pack_kernels
from benchmarks.commands.mechanics import elements, energy, equilibria
from benchmarks.commands.qpcc import qpcc
from benchmarks.commands.steps import gallery, load_errors, reduced_meshes, sofa_meshes
from benchmarks.commands.view import view
from tauten.service.cli.terminal import general_options

app = typer.Typer(
    help="Benchmarks for the makers of tauten; run them on an otherwise idle machine.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)
app.callback()(general_options)
_COMMANDS = (
    *(finger, manipulator, gallery, load_errors, sofa_meshes, reduced_meshes, qpcc, contact_basis),
    *(elements, energy, equilibria, view, closed_loop, first_hour, friction, friction_inverse),
    *(friction_modes, obstacles, contact_loop, still, pack_kernels, check_kernels),
)
for _command in _COMMANDS:
    app.command()(_command)
