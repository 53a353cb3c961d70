"""The contact basis that a benchmark needs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from tauten.reduction import ContactBasis
    from tauten.service.setup import Setup


def basis_of(setup: Setup, robot: str) -> ContactBasis:
    """The contact basis of a setup.

    Raises:
        typer.BadParameter: it has none.
    """
    if isinstance(setup.contact, str):
        raise typer.BadParameter(f"{robot} has no contact basis: tauten reduce {robot} makes one")
    return setup.contact
