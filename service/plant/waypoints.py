"""Targets of one effector over time, and the CSV files that hold them.

| kind | columns |
|---|---|
| point, centre | x, y, z [m] |
| frame | x, y, z [m], qx, qy, qz, qw |
| distance, length, volume | distance, length [m], volume [m³] |

A column t [s] is optional, and columns may come in any order.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from tauten.model import UNIT_LENGTH
from tauten.model.numerics import Array
from tauten.model.schema import EffectorKind
from tauten.reduction import write_text

_POSITION = ("x", "y", "z")
# In the order of goal values.
COLUMNS: dict[EffectorKind, tuple[str, ...]] = {
    "point": _POSITION,
    "centre": _POSITION,
    "frame": (*_POSITION, "qw", "qx", "qy", "qz"),
    "distance": ("distance",),
    "length": ("length",),
    "function": ("value",),
    "volume": ("volume",),
}


class PathError(ValueError):
    """A path that cannot be used; the message names it, the value found and the values allowed."""


@dataclass(frozen=True, slots=True)
class TargetPath:
    """Goal values of one effector over time.

    Attributes:
        times: (m,) ascending from 0 [s].
        values: (m, v) goal values by the effector's kind; of a point positions [m].
        repeats: whether it starts again at the end; otherwise the last target is held.
        kind: of the effector.
    """

    times: Array
    values: Array
    repeats: bool
    kind: EffectorKind = "point"

    @property
    def duration(self) -> float:
        """Seconds of one pass."""
        return float(self.times[-1])

    def at(self, time: float) -> Array:
        """Values (v,) at a time [s], linear between those given; quaternions of length one."""
        if self.repeats and self.duration > 0.0:
            time = time % self.duration
        columns = range(self.values.shape[1])
        found = np.array([np.interp(time, self.times, self.values[:, i]) for i in columns])
        if self.kind == "frame":
            found[3:] /= np.linalg.norm(found[3:])
        return found


def without_sign_changes(quaternions: Array) -> Array:
    """The same rotations (m, 4), each with the sign that is nearer to the one before it."""
    found = quaternions.copy()
    for before, after in pairwise(found):
        if before @ after < 0.0:
            after *= -1.0
    return found


def path_text(path: TargetPath) -> str:
    """A path as the CSV that `tauten stream` reads."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["t", *COLUMNS[path.kind]])
    for time, values in zip(path.times.tolist(), path.values.tolist(), strict=True):
        writer.writerow([repr(value) for value in (time, *values)])
    return text.getvalue()


def save_path(path: TargetPath, file: Path) -> None:
    """Write a path as the CSV that `tauten stream` reads."""
    write_text(file, path_text(path))


def csv_text_path(
    text: str, path: str, kind: EffectorKind, rate: float, repeats: bool
) -> TargetPath:
    """A path from the text of a CSV file with the columns of an effector's kind and, if any, t [s].

    Args:
        text: of the file; its first line names the columns.
        path: name of the file, for errors.
        kind: of the effector.
        rate: targets a second, where there is no column t.
        repeats: whether it starts again at the end.

    Raises:
        PathError: what is wrong, with the line.
    """
    rows = list(csv.reader(text.splitlines(), skipinitialspace=True))
    names = [name.strip() for name in rows[0]] if rows else []
    columns = COLUMNS[kind]
    if not set(columns) <= set(names) or len(set(names)) != len(names):
        raise PathError(
            f"{path}: line 1: found {names}, expected column names {', '.join(columns)} and optionally t"
        )
    lines = [line for line, row in enumerate(rows[1:], 2) if row]  # others are blank
    table = [_numbers(path, line, rows[line - 1], names) for line in lines]
    if not table:
        raise PathError(f"{path}: no points")
    numbers = np.array(table)  # (m, columns)
    values = numbers[:, [names.index(column) for column in columns]]
    times = numbers[:, names.index("t")] if "t" in names else np.arange(len(numbers)) / rate
    times = times - times[0]
    if (np.diff(times) <= 0.0).any():
        line = lines[int(np.flatnonzero(np.diff(times) <= 0.0)[0]) + 1]
        raise PathError(f"{path}: line {line}: t does not grow")
    if kind == "frame":
        values[:, 3:] = _rotations(path, values[:, 3:], lines)
    return TargetPath(times, values, repeats, kind)


def _rotations(path: str, quaternions: Array, lines: Sequence[int]) -> Array:
    """Quaternions (m, 4) of these lines, of length one without changes of sign."""
    lengths = np.linalg.norm(quaternions, axis=1)
    wrong = np.flatnonzero(np.abs(lengths - 1.0) > UNIT_LENGTH)
    if len(wrong):
        raise PathError(
            f"{path}: line {lines[int(wrong[0])]}: the quaternion has length {lengths[wrong[0]]:.6g} and is "
            f"no rotation, allowed is 1 within {UNIT_LENGTH:g}"
        )
    return without_sign_changes(quaternions / lengths[:, None])


def _numbers(path: str, line: int, row: list[str], names: list[str]) -> list[float]:
    if len(row) != len(names):
        raise PathError(f"{path}: line {line}: found {len(row)} values, expected {len(names)}")
    try:
        values = [float(text) for text in row]
    except ValueError as error:
        raise PathError(f"{path}: line {line}: {error}") from error
    if not np.isfinite(values).all():
        raise PathError(f"{path}: line {line}: {', '.join(row)} is not finite")
    return values
