"""`tauten schema`: the JSON Schema of a robot file."""

from __future__ import annotations

import json

import typer


def schema() -> None:
    """Print the JSON Schema of a robot file, with which editors complete and check it."""
    from tauten.service.file_schema import robot_file_schema

    typer.echo(json.dumps(robot_file_schema(), indent=2, ensure_ascii=False))
