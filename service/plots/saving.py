"""Pictures on disk."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from tauten.reduction import atomic_write


def save_figure(figure: Figure, path: str | Path, dpi: int) -> None:
    """Write a picture, whole or not at all; the suffix decides its format, its folder is made when missing.

    Raises:
        OSError: it cannot be written.
    """
    path = Path(path)
    with atomic_write(path) as file:
        figure.savefig(file, format=path.suffix[1:], dpi=dpi)
