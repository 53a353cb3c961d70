"""Changes of a robot file: fields that a command sets, a cable that is drawn; all other lines remain."""

from __future__ import annotations

import json
import re
import secrets
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tauten.model import RobotFileError, load_robot
from tauten.model.numerics import Array
from tauten.model.schema import read_toml
from tauten.reduction import write_text
from tauten.service.new.template import MOVE_TIME, numbers

Fields = Mapping[str, Mapping[str, str]]
CABLE = """\

[[cables]]                        # drawn in the viewer
name = "{name}"
pull_point = {pull_point}    # where it leaves the robot, fixed in space
points = [                        # points of the body that it passes; the last is where it ends
{points}]
max_pull = {max_pull:.4g}                  # GUESS: a tenth of its length [m]
max_tension = {max_tension:.3g}               # GUESS [N]
max_rate = {max_rate:.4g}                  # GUESS: how fast the winch turns [m/s]
max_outside = {outside:.2g}             # how far outside of the mesh its points may lie [m]
"""
PULL = 0.1  # of the length
TENSION = 10.0  # N, where no other cable says what a winch can do


@dataclass(frozen=True, slots=True)
class NewCable:
    """A cable that a user has drawn.

    Attributes:
        name: that no actuator of the robot has.
        points: (p, 3) at rest [m], at least two; the first is where it leaves the robot.
        max_tension: [N].
        max_outside: how far outside of the mesh its points may lie [m].
    """

    name: str
    points: Array
    max_tension: float
    max_outside: float


def cable_text(cable: NewCable) -> str:
    """The table of a cable in a robot file."""
    length = float(np.linalg.norm(np.diff(cable.points, axis=0), axis=1).sum())
    return CABLE.format(
        name=cable.name,
        pull_point=numbers(cable.points[0]),
        points="".join(f"  {numbers(point)},\n" for point in cable.points[1:]),
        max_pull=PULL * length,
        max_tension=cable.max_tension,
        max_rate=PULL * length / MOVE_TIME,
        outside=cable.max_outside,
    )


def add_cable(file: Path, cable: NewCable) -> None:
    """Append a cable to a robot file, whose text remains as it is; a robot that runs is not changed.

    Raises:
        RobotFileError: the file with the cable is no robot; it has not been changed.
        OSError: the file cannot be written.
    """
    if len(cable.points) < 2:
        raise RobotFileError(f"{file}: cable {cable.name!r} needs two points, found 1 or none")
    file = file.resolve()  # not a link to it
    text = file.read_bytes().decode("utf-8")  # line ends as they are
    text += ("" if text.endswith("\n") else "\n") + cable_text(cable)
    # beside the file, because its paths are relative to it
    trial = file.with_name(f".{file.stem}-{secrets.token_hex(8)}.toml")
    try:
        with trial.open("x", encoding="utf-8", newline="") as stream:
            stream.write(text)
        load_robot(trial)
    except RobotFileError as error:
        raise RobotFileError(str(error).replace(str(trial), str(file))) from error
    finally:
        trial.unlink(missing_ok=True)
    write_text(file, text)


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
