"""Tables of `tauten inspect` about a contact basis: provenance, coverage, error curve."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from tauten.model import MeshError, Robot, RobotFileError, load_robot
from tauten.model.numerics import Ints
from tauten.reduction import BasisError, ContactBasis, CurvePoint
from tauten.reduction.contact import SUFFIX, Curve, coverage

log = logging.getLogger(__name__)

_RANGES = 8  # runs of slots that a line of the table names


def found_robot(basis: ContactBasis, file: str, name: str | None, needed: bool) -> Robot | None:
    """The robot a basis was made for: the one named, else that of its name beside it or shipped, if any.

    Of a file beside the basis and a shipped robot it is the one that fits; where neither does, a message
    says why the file cannot be used.

    Args:
        basis: the basis.
        file: that it was read from, or the name of a shipped robot.
        name: robot name or file, None for the name in the provenance.
        needed: raise rather than return None.

    Raises:
        BasisError: the robot named is not the one that the basis was made for.
        RobotFileError, MeshError: it cannot be read.
    """
    robots = [name or basis.provenance.robot]
    own = Path(f"{basis.provenance.robot}.toml")
    beside = Path(file).with_name(own.name)
    is_beside = name is None and own.name == str(own) and file.endswith(SUFFIX) and beside.is_file()
    if is_beside:
        robots.insert(0, str(beside))
    errors = list[Exception]()
    for candidate in robots:
        try:
            robot = load_robot(candidate)
            basis.check_robot(robot)
        except (RobotFileError, MeshError, BasisError) as error:
            errors.append(error)
        else:
            return robot
    if needed:
        raise errors[0]
    if is_beside:
        log.warning("%s", errors[0])
    return None


def kept_curve(basis: ContactBasis, name: str) -> Curve:
    """The error against k that was found when the basis was made.

    Raises:
        BasisError: it was made without.
    """
    points = basis.provenance.curve
    if not points:
        raise BasisError(
            f"{name}: keeps no error curve, k was given: `tauten reduce --curve FILE` makes one"
        )
    return Curve(
        k=np.array([point.k for point in points]),
        training=np.array([point.training for point in points]),
        held_out=np.array([point.held_out for point in points]),
        force=np.array([point.force for point in points]),
        tip=np.array([point.tip for point in points]),
    )


def basis_tables(basis: ContactBasis, name: str, robot: Robot | None) -> list[Table]:
    """Provenance, coverage, and the error curve if there is one."""
    entries = asdict(basis.provenance)
    del entries["curve"]  # has a table of its own
    result = [origin_table("contact basis", name, entries), _coverage(basis, robot)]
    if basis.provenance.curve:
        result.append(_errors(basis.provenance.curve, basis.k))
    return result


def origin_table(title: str, name: str, entries: dict[str, Any]) -> Table:
    """Where a basis comes from, one entry a row: three digits, lengths in mm, nothing that is not known.

    Entries whose names begin with "tip" or "pressed" are lengths [m].
    """
    table = Table("", title=title)
    table.add_column(name, overflow="fold")  # digests are never cut
    for entry, value in entries.items():
        words = entry.replace("_", " ")
        if value is None or value != value:  # nobody computed it
            continue
        if isinstance(value, list | tuple):
            text = ", ".join(f"{first} {second}" for first, second in value)
        elif isinstance(value, float) and words.startswith(("tip", "pressed")):
            text = f"{1e3 * value:.3g} mm"
        else:
            text = f"{value:.3g}" if isinstance(value, float) else str(value)
        table.add_row(words, text)
    return table


def _coverage(basis: ContactBasis, robot: Robot | None) -> Table:
    """Candidates with and without a mode: contact on the latter has to wait for enrichment."""
    table = Table(title="coverage: contact where no mode touches needs extra columns")
    table.add_column("contact pair")
    for column in ("modes", "candidates", "untouched"):
        table.add_column(column, justify="right")
    table.add_column("slots without a mode")
    if robot is not None:
        for pair in coverage(robot, basis):
            sizes = (len(pair.modes), len(pair.slots), len(pair.untouched))
            table.add_row(pair.pair, *map(str, sizes), ranges(pair.untouched))
    untouched = basis.untouched()
    slots = "" if robot is not None else ranges(untouched)
    table.add_row("all", str(basis.k), str(basis.n_c), str(len(untouched)), slots)
    return table


def _errors(points: Sequence[CurvePoint], chosen: int) -> Table:
    table = Table(title="error against k: √ of contact energy lost, largest held-out errors")
    for column in ("k", "training", "held out", "force [N]", "effector [mm]"):
        table.add_column(column, justify="right")
    for point in points:
        values = (point.training, point.held_out, point.force, 1e3 * point.tip)
        style = "bold" if point.k == chosen else None
        table.add_row(str(point.k), *(f"{value:.3g}" for value in values), style=style)
    return table


def ranges(slots: Ints | Sequence[int]) -> str:
    """Ascending numbers as ranges, "0-4, 7, 9-12", cut short with "..." after some."""
    slots = np.asarray(slots)
    parts = np.split(slots, np.flatnonzero(np.diff(slots) > 1) + 1) if len(slots) else []
    texts = [f"{part[0]}-{part[-1]}" if len(part) > 1 else f"{part[0]}" for part in parts]
    more = [] if len(texts) <= _RANGES else ["..."]
    return ", ".join(texts[:_RANGES] + more)
