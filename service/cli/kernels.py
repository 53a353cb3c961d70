"""`tauten kernels`: what is shipped compiled, whether it serves here, and how it is packed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from tauten.service.cli.terminal import Json, progress_bar, writable, write_json

kernels = typer.Typer(
    help="Compiled kernels: what is shipped serves this machine or not (without a command); packing it.",
    invoke_without_command=True,
)


@kernels.callback()
def status(context: typer.Context) -> None:
    """Say how many kernels need not be compiled on this machine, and why not, where none."""
    if context.invoked_subcommand is not None:
        return
    from tauten.service.kernels import take_inventory

    found = take_inventory()
    table = Table("", "", title="tauten kernels", show_header=False)
    table.add_row("kernels of tauten", str(found.kernels))
    table.add_row("compiled for", found.machine)
    table.add_row("shipped and used here", f"{found.served}, with {found.entries} sets of types")
    table.add_row("changed since they were packed", str(found.changed))
    table.add_row("compiled here", f"{found.compiled}, {1e-6 * found.size:.0f} MB")
    console = Console(markup=False)
    console.print(table)
    console.print(f"compiled here: {found.folder}", soft_wrap=True)
    if found.why_not:
        console.print(f"none of the shipped kernels is used: {found.why_not}", soft_wrap=True)


@kernels.command()
def pack(
    out: Annotated[
        Path | None,
        typer.Option(callback=writable, help="File; default: where tauten looks for it."),
    ] = None,
    everything: Annotated[
        bool, typer.Option("--everything", help="Also all that was compiled here before.")
    ] = False,
) -> None:
    """Run README's first command and the shipped robots, and pack the kernels that they need."""
    from tauten.model.kernels import SHIPPED, seed_name
    from tauten.service.kernels import LARGEST, pack_kernels

    with progress_bar("packing kernels") as report:
        packed = pack_kernels(out or SHIPPED / seed_name(), report, everything)
    print(f"{packed.file}: {packed.entries} entries, {1e-6 * packed.size:.2f} MB")
    if packed.size > LARGEST:
        print(f"larger than {1e-6 * LARGEST:g} MB: too large for the repository")
        raise typer.Exit(1)


@kernels.command()
def check(
    most: Annotated[int, typer.Option(min=0, help="Kernels that may be compiled.")] = 5,
    json_file: Json = None,
) -> None:
    """Run the demo as after installation. Exit code 1: it compiled more kernels than permitted."""
    from tauten.model.kernels import seed_file
    from tauten.service.kernels import SEEDED, first_demos

    file = seed_file()
    if file is None or not file.is_file():
        print("no kernels are shipped for this Python, numba and system: nothing to check")
        return
    with progress_bar("demo") as report:
        (found,) = first_demos(report, (SEEDED,))
    print(f"compiled: {found.compiled} kernels; demo: {found.seconds:.0f} s")
    write_json(found, json_file)
    if found.compiled > most:
        print(f"more than {most}: run tauten kernels pack, and commit {file.name}")
        raise typer.Exit(1)
