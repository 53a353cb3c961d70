"""Options before any command: the version, and log messages on stderr as text or JSON."""

from __future__ import annotations

import json
import logging
from datetime import UTC, datetime
from typing import Annotated, Literal

import typer

LogFormat = Literal["text", "json"]
FOREIGN = ("websockets", "viser", "httpx", "matplotlib")  # their news are of no command of ours


class JsonLines(logging.Formatter):
    """One object for each line: time (UTC, ISO 8601), level, logger, message, and the traceback if any."""

    def format(self, record: logging.LogRecord) -> str:
        """A record as a line."""
        fields = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
        }
        if record.exc_info:
            fields["traceback"] = self.formatException(record.exc_info)
        return json.dumps(fields, ensure_ascii=False)


def set_up_logging(level: str, form: LogFormat) -> None:
    """Log to stderr."""
    handler = logging.StreamHandler()
    if form == "json":
        handler.setFormatter(JsonLines())
    else:
        text = "%(asctime)s %(levelname)s %(name)s: %(message)s"
        handler.setFormatter(logging.Formatter(text))
    logging.basicConfig(level=level.upper(), handlers=[handler])
    for library in FOREIGN:
        logging.getLogger(library).setLevel(
            max(logging.WARNING, logging.getLevelName(level.upper()))
        )


def show_version(asked: bool) -> None:
    """Print the version that is installed, and exit; callback of the option.

    Raises:
        typer.Exit: it was.
    """
    if asked:
        from importlib.metadata import version

        typer.echo(f"tauten {version('tauten')}")
        raise typer.Exit


def general_options(
    log_level: Annotated[
        Literal["debug", "info", "warning", "error"],
        typer.Option(help="Least level of messages on stderr."),
    ] = "info",
    log_format: Annotated[
        LogFormat, typer.Option(help="Plain lines, or one JSON object on each line.")
    ] = "text",
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=show_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    """Options before any command."""
    set_up_logging(log_level, log_format)
