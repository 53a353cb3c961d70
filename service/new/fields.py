"""Fields of tables in a robot file that are set by a command; comments and all other lines remain."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tauten.model.schema import RobotFileError, read_toml
from tauten.reduction import write_text

Fields = Mapping[str, Mapping[str, str]]


def fields_text(fields: Fields) -> str:
    """The lines to write into a robot file, for a terminal."""
    lines: list[str] = []
    for table, values in fields.items():
        lines += [f"[{table}]", *(f"{name} = {_literal(text)}" for name, text in values.items())]
    return "\n".join(lines)


def set_fields(file: Path, fields: Fields) -> None:
    """Set texts in tables of a robot file; a field that is there keeps its comment.

    Raises:
        RobotFileError: the file writes one of the tables so that its text cannot be changed; it is as it was.
        OSError: the file cannot be written.
    """
    contents, text = read_toml(file), file.read_bytes().decode("utf-8")
    for table, values in fields.items():
        old = contents.get(table, {})
        contents[table] = old | dict(values) if isinstance(old, dict) else values
        found = next((new for new in _drafts(text, table, values) if _holds(new, contents)), None)
        if found is None:
            raise RobotFileError(
                f"{file}: has no line [{table}] below which its fields can be set; set them by hand:\n"
                f"{fields_text(fields)}"
            )
        text = found
    write_text(file, text)


def _drafts(text: str, table: str, values: Mapping[str, str]) -> Iterator[str]:
    """The text with fields set below each line that looks like the table's, then below a new one."""
    for head in re.finditer(rf"^[ \t]*\[{re.escape(table)}\][^\n]*\n?", text, re.M):
        begin, line = head.end(), head[0] if head[0].endswith("\n") else f"{head[0]}\n"
        following = re.search(r"^[ \t]*\[", text[begin:], re.M)
        end = len(text) if following is None else begin + following.start()
        yield text[: head.start()] + line + _with_fields(text[begin:end], values) + text[end:]
    gap = "" if text.endswith("\n") else "\n"
    yield f"{text}{gap}\n[{table}]\n{_with_fields('', values)}"


def _holds(text: str, contents: dict[str, Any]) -> bool:
    """Whether a text is TOML of some contents."""
    try:
        return tomllib.loads(text) == contents
    except tomllib.TOMLDecodeError:
        return False


def _with_fields(body: str, values: Mapping[str, str]) -> str:
    """The lines of a table with fields set: new ones stand first."""
    for name, value in reversed(list(values.items())):
        key = rf"(?:{re.escape(name)}|\"{re.escape(name)}\"|'{re.escape(name)}')"
        field = re.compile(rf"^([ \t]*{key}[ \t]*=[ \t]*)(\"(?:[^\"\\\n]|\\.)*\"|'[^'\n]*')", re.M)
        line = _literal(value)
        if field.search(body):
            body = field.sub(lambda found, line=line: f"{found[1]}{line}", body, count=1)  # type: ignore[misc]
        else:
            body = f"{name} = {line}\n{body}"
    return body


def _literal(text: str) -> str:
    """A text as TOML writes it."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
