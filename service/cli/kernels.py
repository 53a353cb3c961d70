"""`tauten kernels`: what is shipped compiled, and whether it serves here."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table


def kernels() -> None:
    """Say how many kernels need not be compiled on this machine, and why not, where none."""
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
    if found.not_kept:
        console.print(
            f"every start compiles the others again, they cannot be kept: {found.not_kept}; "
            "set NUMBA_CACHE_DIR to a folder that you alone can write",
            soft_wrap=True,
        )
    if found.why_not:
        console.print(f"none of the shipped kernels is used: {found.why_not}", soft_wrap=True)
