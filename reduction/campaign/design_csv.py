"""Designs of excitation from a table of the user."""

from __future__ import annotations

import csv
from itertools import groupby
from pathlib import Path

import numpy as np

from tauten.model import Robot
from tauten.model.numerics import Array
from tauten.model.schema import cause
from tauten.reduction.campaign.designs import Design, DesignError, Run


def from_csv(robot: Robot, path: str | Path) -> Design:
    """Runs from a table with one equilibrium in each row.

    Columns: `run` (rows of equal value that follow one another are one run), `pull_CABLE` [m] for
    every cable, and optionally `gravity_x`, `gravity_y`, `gravity_z` [m/s²] (else the robot's)
    and `force_EFFECTOR_x`, … [N] (else 0).

    Raises:
        DesignError: unknown or missing columns, a field that is no finite number, a pull beyond the
            limits; names the file and the line.
    """
    path = Path(path)
    positions = [f"pull_{name}" for name in robot.actuators.names]
    gravities = [f"gravity_{axis}" for axis in "xyz"]
    forces = [f"force_{name}_{axis}" for name in robot.effector_names for axis in "xyz"]
    default = {
        **dict.fromkeys(forces, 0.0),
        **dict(zip(gravities, robot.gravity, strict=True)),
    }
    lines = _read(path, ["run", *positions], [*gravities, *forces])
    values = [default | _numbers(path, row, line) for row, line in enumerate(lines, start=2)]
    for row, value in enumerate(values, start=2):
        _check_position(robot, f"{path}, line {row}", np.array([value[name] for name in positions]))
    runs = []
    for _, group in groupby(range(len(lines)), key=lambda i: lines[i]["run"]):
        chosen = [values[i] for i in group]
        runs.append(Run(*(_table(chosen, names) for names in (positions, gravities, forces))))
    return Design(f"{path.name}: {len(runs)} runs", tuple(runs))


def _read(path: Path, required: list[str], optional: list[str]) -> list[dict[str, str]]:
    """Lines of a CSV file with a header, columns checked."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file, restkey="(more fields than columns)", restval="")
            header = list(reader.fieldnames or [])
            lines = list(reader)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DesignError(f"{path}: cannot be read ({cause(error)})") from error
    missing = [name for name in required if name not in header]
    unknown = [name for name in header if name not in [*required, *optional]]
    if missing or unknown:
        raise DesignError(
            f"{path}: columns missing: {', '.join(missing) or 'none'}; "
            f"unknown: {', '.join(unknown) or 'none'}; "
            f"needed are {', '.join(required)}; allowed are {', '.join(optional)}"
        )
    if not lines:
        raise DesignError(f"{path}: has no rows, at least one is needed")
    return lines


def _numbers(path: Path, row: int, line: dict[str, str]) -> dict[str, float]:
    """Every field of a line but `run` as a finite number."""
    numbers = {}
    for name, text in line.items():
        if name == "run":
            continue
        try:
            numbers[name] = float(text)
        except (TypeError, ValueError):
            numbers[name] = np.nan
        if not np.isfinite(numbers[name]):
            raise DesignError(f"{path}, line {row}: {name} is {text!r}, expected a finite number")
    return numbers


def _check_position(robot: Robot, where: str, position: Array) -> None:
    low, high = robot.limits.position_min, robot.limits.position_max
    for i in np.flatnonzero((position < low) | (position > high)):
        raise DesignError(
            f"{where}: pull_{robot.actuators.names[i]} is {position[i]} m, "
            f"allowed are {low[i]} to {high[i]} m"
        )


def _table(rows: list[dict[str, float]], names: list[str]) -> Array:
    """Columns `names` of the rows: (len(names), len(rows))."""
    return np.array([[row[name] for row in rows] for name in names])
