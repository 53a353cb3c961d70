"""Files that commands are asked to write: refused before anything is computed for them."""

from __future__ import annotations

import tempfile
from pathlib import Path

import typer


def writable(path: Path | None) -> Path | None:
    """Check that a file or folder can be written; callback of an option.

    Args:
        path: of the file or folder; what does not exist is made in the nearest folder that does.

    Raises:
        typer.BadParameter: it cannot, and why.
    """
    if path is None:
        return path
    folder = path.absolute()
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):
            return path  # a pipe or a device remains one
        while not folder.is_dir():
            folder = folder.parent
        with tempfile.TemporaryFile(dir=folder):
            return path
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise typer.BadParameter(f"{path} cannot be written: {folder}: {reason}") from error
