"""What commands show and write: progress bars, tables, JSON; files that cannot be written are refused."""

from __future__ import annotations

import json
import logging
import os
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from tauten.model import Robot
    from tauten.service.process import Progress
    from tauten.service.tables import Page

log = logging.getLogger(__name__)

_SILENCE = 30.0  # s between two lines about the progress, where there is no terminal


def writable(path: Path | None) -> Path | None:
    """Check that a file or folder can be written; callback of an option.

    What does not exist is made in the nearest folder that does.

    Raises:
        typer.BadParameter: it cannot, and why.
    """
    if path is None:
        return path
    folder = Path(os.path.realpath(path))
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


def drawable(path: Path | None) -> Path | None:
    """Check that a picture can be drawn into a file, before what takes minutes; callback of an option.

    The ending of the file says of which kind the picture is.

    Raises:
        typer.BadParameter: it cannot, and why.
    """
    if path is None:
        return path
    from matplotlib.backend_bases import FigureCanvasBase

    if path.is_dir():
        raise typer.BadParameter(f"{path} is a folder: name a file, such as {path / 'figure.png'}")
    endings = [f".{kind}" for kind in sorted(FigureCanvasBase.get_supported_filetypes())]
    if path.suffix.lower() not in endings:
        raise typer.BadParameter(f"{path}: a picture ends with one of {', '.join(endings)}")
    return writable(path)


@contextmanager
def progress_bar(title: str) -> Iterator[Progress]:
    """A bar on stderr while a command works; where that is no terminal, a line in the log twice a minute.

    Yields:
        What the work calls with the share that is done since the last call (1 is all), and a text.
    """
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress

    console = Console(stderr=True, markup=False)
    if not console.is_terminal:
        yield _lines(title)
        return
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task(escape(title), total=1.0)

        def report(share: float, what: str = "") -> None:
            bar.update(task, advance=share, description=escape(what or title))

        yield report


class WithKernels:
    """A text of a command that waits for others, and how many kernels have been compiled meanwhile."""

    def __init__(self, text: str) -> None:
        self._text, self._before = text, self._count()

    def __rich__(self) -> str:
        """The text as it is shown now."""
        more = self._count() - self._before
        return (
            f"{self._text}; kernels compiled so far, once for all: {more}" if more else self._text
        )

    @staticmethod
    def _count() -> int:
        from tauten.service.kernels import compiled_here

        return len(compiled_here())


def _lines(title: str) -> Progress:
    done, said = 0.0, time.monotonic()

    def report(share: float, what: str = "") -> None:
        nonlocal done, said
        done, now = done + share, time.monotonic()
        if now >= said + _SILENCE:
            log.info("%s: %.0f %%", what or title, 100.0 * done)
            said = now

    return report


def show_result(
    result: Any,
    page: Page,
    json_file: Path | None,
    markdown: Path | None = None,
) -> None:
    """Write a result into the files that were asked for, and print it to stdout.

    It is printed last, because a pipe that nobody reads to its end ends the command; and also where a file
    cannot be written.
    """
    from rich.console import Console

    from tauten.service.tables import Numbers

    try:
        write_json(result, json_file)
        if markdown is not None:
            page.put_into(markdown)
    finally:
        console = Console(markup=False)
        for part in page.parts:
            console.print(part.rich(console.width) if isinstance(part, Numbers) else part)
        console.print(page.about)


def show_mesh_error(path: Path, robot: Robot) -> None:
    """Print the error of a robot's mesh, as far as it is known."""
    from rich.console import Console

    from tauten.service.check import mesh_error_text

    Console(markup=False).print(f"mesh error: {mesh_error_text(path, robot.digest)}")


def write_json(result: Any, path: Path | None) -> None:
    """Write numbers as JSON, the whole file or nothing."""
    if path is None:
        return
    from tauten.reduction import write_text

    contents: Any
    if isinstance(result, Mapping):
        contents = result
    elif isinstance(result, (list, tuple)):
        contents = [asdict(item) for item in result]
    else:
        contents = asdict(result)
    write_text(path, json.dumps(contents, indent=2) + "\n")
