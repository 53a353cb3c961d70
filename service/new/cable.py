"""A further cable in a robot file: a table at its end; nothing else of the file changes."""

from __future__ import annotations

import secrets
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tauten.model import RobotFileError, load_robot
from tauten.model.numerics import Array
from tauten.reduction import write_text
from tauten.service.new.template import MOVE_TIME, numbers

TEXT = """\

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
    return TEXT.format(
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
