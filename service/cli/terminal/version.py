"""The option `--version`."""

from __future__ import annotations

from typing import Annotated

import typer


def show_version(asked: bool) -> None:
    """Print the version that is installed, and exit; callback of the option.

    Raises:
        typer.Exit: it was.
    """
    if asked:
        from importlib.metadata import version

        typer.echo(f"tauten {version('tauten')}")
        raise typer.Exit


Version = Annotated[
    bool,
    typer.Option(
        "--version", callback=show_version, is_eager=True, help="Print the version and exit."
    ),
]
