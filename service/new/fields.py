"""Fields of tables in a robot file that are set by a command; comments and all other lines remain."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from tauten.model.schema import RobotFileError, read_toml
from tauten.service.process import write_text

Fields = Mapping[str, Mapping[str, str]]


def fields_text(fields: Fields) -> str:
    """The lines to write into a robot file, for a terminal.

    Args:
        fields: tables, and texts by the name of the field.
    """
    lines: list[str] = []
    for table, values in fields.items():
        lines += [f"[{table}]", *(f'{name} = "{value}"' for name, value in values.items())]
    return "\n".join(lines)


def set_fields(file: Path, fields: Fields) -> None:
    """Set texts in tables of a robot file; a field that is there keeps its comment.

    Args:
        file: the robot file.
        fields: tables, and texts by the name of the field.

    Raises:
        RobotFileError: the file writes one of the tables in another form than under a [header].
        OSError: the file cannot be written.
    """
    file = file.resolve()
    mode, text = file.stat().st_mode, file.read_bytes().decode("utf-8")
    contents = read_toml(file)
    for table, values in fields.items():
        head = re.search(rf"^[ \t]*\[{re.escape(table)}\][^\n]*\n?", text, re.M)
        if head is None and table in contents:
            raise RobotFileError(
                f"{file}: has no line [{table}]: set {fields_text(fields)!r} by hand"
            )
        if head is None:
            text += ("" if text.endswith("\n") else "\n") + f"\n[{table}]\n"
            begin = end = len(text)
        else:
            if not head[0].endswith("\n"):
                text += "\n"
            begin = head.end() if head[0].endswith("\n") else len(text)
            following = re.search(r"^[ \t]*\[", text[begin:], re.M)
            end = len(text) if following is None else begin + following.start()
        text = text[:begin] + _with_fields(text[begin:end], values) + text[end:]
    write_text(file, text)
    file.chmod(mode)


def _with_fields(body: str, values: Mapping[str, str]) -> str:
    """The lines of a table with fields set: new ones stand first."""
    for name, value in reversed(list(values.items())):
        field = re.compile(
            rf"^([ \t]*{re.escape(name)}[ \t]*=[ \t]*)(\"[^\"\n]*\"|'[^'\n]*')", re.M
        )
        line = f'"{value}"'
        if field.search(body):
            body = field.sub(lambda found, line=line: f"{found[1]}{line}", body, count=1)  # type: ignore[misc]
        else:
            body = f"{name} = {line}\n{body}"
    return body
