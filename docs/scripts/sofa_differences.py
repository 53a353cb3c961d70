"""What settings of the robot files in `coming_from/sofa` change, one by one: the table of `sofa_ports`."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from sofa_robots import port, settled

from tauten.model import load_robot
from tauten.service.tables import Numbers

if TYPE_CHECKING:
    from sofa_ports import Curve


@dataclass(frozen=True, slots=True)
class Difference:
    """What a setting changes in one state.

    Attributes:
        setting: of the robot file, as SOFA has it.
        robot: name of the file.
        state: in words.
        tip: distance of the tips with and without it [mm].
        effort: largest difference of efforts and positions, relative to the largest with it.
    """

    setting: str
    robot: str
    state: str
    tip: float
    effort: float


@dataclass(frozen=True, slots=True)
class Change:
    """A setting and the state in which it is left out.

    Attributes:
        setting: in words.
        robot: name of the file.
        state: in words.
        without: texts of the file that stand for the setting, and what replaces them.
        position: positions by name of the actuator.
        effort: efforts by name of the actuator; cables without either are slack.
        both: texts of the file that are replaced with and without the setting.
    """

    setting: str
    robot: str
    state: str
    without: tuple[tuple[str, str], ...]
    position: dict[str, float]
    effort: dict[str, float]
    both: tuple[tuple[str, str], ...] = ()


FALL = (("gravity = [0.0, 0.0, 0.0]", "gravity = [0.0, -9.81, 0.0]"),)
CHANGES = (
    Change(
        'extrapolate_from = "centre"', "trunk", "cable L0 at 15 mm",
        (('extrapolate_from = "centre"\n', ""),), {"L0": 0.015}, {},
    ),
    Change(
        'mass = "nodes"', "trunk", "gravity along −y, cable L0 at 10 mm",
        (('mass = "nodes"\n', ""),), {"L0": 0.010}, {}, FALL,
    ),
    Change(
        "own_surface = true", "pneunets", "3 kPa",
        (("own_surface = true\n", ""), ("max_outside = 1e-5\n", "")), {}, {"air": 3e3},
    ),
    Change(
        "own_surface = true", "gripper_finger", "60 kPa",
        (("own_surface = true\n", ""),), {}, {"air": 6e4},
    ),
    Change(
        "contact.distance = 1e-3", "finger", "cable at 25 mm",
        (("distance = 1e-3 ", "distance = 0.0 "),), {"tendon": 0.025}, {},
    ),
    Change(
        'points = "vertices"', "finger", "cable at 25 mm",
        (('points = "vertices"\n', ""),), {"tendon": 0.025}, {},
    ),
)  # fmt: skip


def difference(data: Path, change: Change) -> Difference:
    """How far a robot in a state is from the one without a setting.

    Args:
        data: with the meshes.
        change: the setting.
    """
    found = []
    for replaced in (change.both, (*change.both, *change.without)):
        with tempfile.TemporaryDirectory() as folder:
            port(data, Path(folder), change.robot)
            path = Path(folder) / f"{change.robot}.toml"
            text = path.read_text(encoding="utf-8")
            for old, new in replaced:
                if old not in text:
                    raise ValueError(f"{path.name}: {old!r} is not in it")
                text = text.replace(old, new)
            path.write_text(text, encoding="utf-8")
            robot = load_robot(path)
        position, effort = np.full(robot.n_a, np.nan), np.zeros(robot.n_a)
        for name, value in change.position.items():
            place = robot.actuators.names.index(name)
            position[place], effort[place] = value, np.nan
        for name, value in change.effort.items():
            effort[robot.actuators.names.index(name)] = value
        found.append(settled(robot, [(position, effort)], "full"))
    (tip, *efforts), (other, *others) = found
    given = (
        1 if change.position else 0
    )  # efforts where positions are given, positions where efforts are
    lam = efforts[1 - given], others[1 - given]
    return Difference(
        change.setting,
        change.robot,
        change.state,
        float(np.linalg.norm(tip - other)),
        float(np.abs(lam[0] - lam[1]).max() / np.abs(lam[0]).max()),
    )


def difference_table(found: list[Difference], curves: list[Curve]) -> Numbers:
    """The differences of settings, and of elements, which no setting takes away."""
    rows = [
        (f"`{one.setting}`", one.robot, one.state, f"{one.tip:.2g}", f"{100.0 * one.effort:.2g}")
        for one in found
    ]
    rows += [
        ("none: `method='large'`", curve.robot, "17 states", f"{curve.tip_error:.2g}",
         f"{100.0 * curve.effort_error:.2g}")
        for curve in curves if curve.robot == "diamond"
    ]  # fmt: skip
    head = ("setting", "robot", "state", "tip [mm]", "effort or position [%]")
    return Numbers("", head, tuple(rows), text_columns=3)
