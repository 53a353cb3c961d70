"""Paths of targets: shapes that start at rest, what the cables can reach, CSV files."""

from __future__ import annotations

import csv
import logging
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.interpolate import CubicSpline

from tauten.model import Command, Robot, Simulator, command_range
from tauten.model.numerics import Array

log = logging.getLogger(__name__)

Shape = Literal["circle", "line", "figure-eight", "step"]
Plane = Literal["xy", "xz", "yz"]
SHAPES: tuple[Shape, ...] = ("circle", "line", "figure-eight", "step")

_SAMPLES = 720  # of an analytic shape: a chord is then nowhere farther off than 1e-5 of its size
_REACH_SAMPLES = 12  # equilibria of `reach` in half a turn, each takes some control steps to find
_REACH_TURNS = 3
_SETTLED = 1e-4  # m; targets need not be exact equilibria
_NEARLY_SETTLED = 1e-3  # m
_MAX_STEPS = 80


@dataclass(frozen=True, slots=True)
class PathSettings:
    """How a path is made.

    Attributes:
        effector: number of the effector it is for.
        rate: points a second of a CSV file without times.
        size: of a shape [m]; None: a tenth of the robot's size.
        period: seconds of one pass.
        plane: that a shape lies in.
        fraction: of the largest pull or tension, for "reach".
        repeats: whether a CSV file starts again at its end.
    """

    effector: int = 0
    rate: float = 50.0
    size: float | None = None
    period: float = 10.0
    plane: Plane = "xz"
    fraction: float = 0.8
    repeats: bool = False


class PathError(ValueError):
    """A path that cannot be used; the message names it, the value found and the values allowed."""


@dataclass(frozen=True, slots=True)
class TargetPath:
    """Positions over time.

    Attributes:
        times: (m,) ascending from 0 [s].
        points: (m, 3) [m].
        repeats: whether it starts again at the end; otherwise the last point is held.
        shortened: equilibria of "reach" whose load was shortened, because the robot has none under the whole.
    """

    times: Array
    points: Array
    repeats: bool
    shortened: int = 0

    @property
    def duration(self) -> float:
        """Seconds of one pass."""
        return float(self.times[-1])

    def at(self, time: float) -> Array:
        """Position (3,) at a time [s], linear between the points given."""
        if self.repeats and self.duration > 0.0:
            time = time % self.duration
        return np.array([np.interp(time, self.times, self.points[:, i]) for i in range(3)])


def make_path(name: str, robot: Robot, settings: PathSettings) -> TargetPath:
    """A path by name: a shape, "reach", or a CSV file.

    Args:
        name: of the shape, "reach", or the CSV file.
        robot: that is to follow it.
        settings: of the path.

    Raises:
        PathError: no such path, or one that cannot be made.
    """
    if name == "reach":
        return reach_path(robot, settings.effector, settings.fraction, settings.period)
    start = robot.effector(robot.rest())[settings.effector]
    return path_from(name, start, robot.size, settings)


def path_from(name: str, start: Array, robot_size: float, settings: PathSettings) -> TargetPath:
    """A path by name that needs no model: a shape, or a CSV file.

    Args:
        name: of the shape or the CSV file.
        start: (3,) where the effector rests [m].
        robot_size: of the robot [m].
        settings: of the path.

    Raises:
        PathError: no such path, or one that cannot be made.
    """
    for shape in SHAPES:
        if name == shape:
            size = 0.1 * robot_size if settings.size is None else settings.size
            return shape_path(shape, start, size, settings.period, settings.plane)
    if not name.endswith(".csv"):
        allowed = ", ".join([*SHAPES, "reach"])
        raise PathError(f"no path {name!r}: allowed are {allowed} and files that end in .csv")
    return csv_path(Path(name), settings.rate, settings.repeats)


def shape_path(shape: Shape, start: Array, size: float, period: float, plane: Plane) -> TargetPath:
    """A shape that starts and ends at a point.

    Args:
        shape: which.
        start: (3,) where it starts [m].
        size: radius of a circle, half width of a figure eight, length of a line or step [m].
        period: seconds of one pass.
        plane: that it lies in; a line and a step go along the first axis of it.
    """
    u, v = np.eye(3)["xyz".index(plane[0])], np.eye(3)["xyz".index(plane[1])]
    times = np.linspace(0.0, period, _SAMPLES + 1)
    angle = 2.0 * np.pi * times / period
    along, across = _unit_shape(shape, angle)
    points = start + size * (np.outer(along, u) + np.outer(across, v))
    return TargetPath(times, points, True)


def _unit_shape(shape: Shape, angle: Array) -> tuple[Array, Array]:
    """Coordinates of a shape of size 1 that starts at the origin, over angles 0 to 2 π."""
    flat = np.zeros_like(angle)
    if shape == "circle":
        return np.sin(angle), 1.0 - np.cos(angle)
    if shape == "figure-eight":
        return np.sin(angle), np.sin(angle) * np.cos(angle)
    if shape == "line":
        return 0.5 * (1.0 - np.cos(angle)), flat
    return (angle >= np.pi).astype(float), flat


def reach_path(robot: Robot, effector: int, fraction: float, period: float) -> TargetPath:
    """Where an effector gets when the cables are pulled: a path that the robot can follow.

    One cable is pulled and let go once; several are pulled one after another, in turns that grow
    and fade, in the order of the directions they pull the effector to, and other actuators alike. What is
    commanded of each, and how far, says `command_range`. A smooth curve through some equilibria of the
    full-order model with pointwise contact. Where there is no equilibrium under a load, the path goes through
    the last one on the way to it.

    Args:
        robot: the robot.
        effector: its number.
        fraction: of the range of each actuator that is used.
        period: seconds of one pass.

    Raises:
        PathError: the model finds no equilibrium but that at rest.
    """
    reach, shares = command_range(robot), fraction * reach_shares(directions(robot, effector))
    simulator, shortened = Simulator(robot, contact="full"), 0
    found: dict[bytes, Array] = {}  # one cable passes each equilibrium twice
    for share in shares:
        if share.tobytes() not in found:
            shortened += not _settled_or_shortened(simulator, reach.command(share))
            found[share.tobytes()] = simulator.effector[effector]
    points = np.array([found[share.tobytes()] for share in shares])
    if shortened > 0 and np.ptp(points, axis=0).max() < _NEARLY_SETTLED:
        raise PathError(f"reach: {robot.name} finds no equilibrium but that at rest")
    if shortened > 0:
        log.warning(
            "reach: %s has no equilibrium under %d of %d loads, which were shortened",
            robot.name, shortened, len(found),
        )  # fmt: skip
    knots = np.linspace(0.0, period, len(points))
    times = np.linspace(0.0, period, _SAMPLES + 1)
    curve = CubicSpline(knots, points, bc_type="periodic")
    return TargetPath(times, curve(times), True, shortened)


def _settled_or_shortened(simulator: Simulator, command: Command) -> bool:
    """Settle under a command; whether that is nearly the whole load."""
    before = simulator.state, simulator.forces
    held = command.pull, command.tension
    report = simulator.settle(*held, _SETTLED, _MAX_STEPS, load_steps=False)
    if report.movement < _NEARLY_SETTLED:
        return True
    simulator.start_from(*before)
    return simulator.settle(*held, _SETTLED, _MAX_STEPS).converged


def bending_command(robot: Robot, effector: int = 0) -> Command:
    """The command that bends a robot as far as its first actuator can.

    Each actuator gets as much of its range as it moves the effector into the direction of the first one;
    cables on the other side get nothing.

    Args:
        robot: the robot.
        effector: number of the effector.
    """
    return command_range(robot).command(np.cos(directions(robot, effector)))


def directions(robot: Robot, effector: int) -> Array:
    """Into which direction each cable pulls an effector at rest, seen in the plane they move it in
    most, from the first cable's: (n_a,) [rad].
    """
    rest, robot = robot.rest(), robot.fork()
    system = robot.linearise(rest, None, replace(robot.integration, static=True))
    rows = robot.rows(rest, contacts=False)
    row = slice(3 * effector, 3 * effector + 3)
    moved = rows.effectors.dense()[row] @ system.solve(rows.actuators.dense().T)  # (3, n_a)
    plane = np.linalg.svd(moved)[0][:, :2]  # (3, 2)
    x, y = plane.T @ moved
    angle = np.arctan2(y, x)
    turned: Array = (angle - angle[0]) % (2.0 * np.pi)
    return turned


def reach_shares(angles: Array) -> Array:
    """Shares −1 to 1 of the ranges of the actuators on the way of `reach`, zero at both ends: (m, n_a).

    Args:
        angles: (n_a,) into which direction each moves the effector [rad].
    """
    turns = 1 if len(angles) == 1 else _REACH_TURNS
    half = np.linspace(0.0, np.pi, turns * _REACH_SAMPLES + 1)
    rise = 0.5 * (1.0 - np.cos(half))
    swell = np.concatenate([rise, rise[-2::-1]])  # (m,), exactly the same up and down
    if len(angles) == 1:
        return swell[:, None]
    phase = np.linspace(0.0, 2.0 * np.pi * turns, len(swell))
    shares: Array = swell[:, None] * np.cos(phase[:, None] - angles)
    return shares


def csv_path(path: Path, rate: float, repeats: bool) -> TargetPath:
    """A path from a CSV file with columns x, y, z [m] and, if any, t [s].

    Args:
        path: the file; its first line names the columns.
        rate: points a second, where there is no column t.
        repeats: start again at the end.

    Raises:
        PathError: what is wrong, with the line.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise PathError(f"{path}: cannot be read ({error})") from error
    rows = list(csv.reader(lines, skipinitialspace=True))
    names = [name.strip() for name in rows[0]] if rows else []
    if not {"x", "y", "z"} <= set(names) or len(set(names)) != len(names):
        raise PathError(
            f"{path}: line 1: found {names}, expected column names x, y, z and optionally t"
        )
    values = [_numbers(path, line, row, names) for line, row in enumerate(rows[1:], 2) if row]
    if not values:
        raise PathError(f"{path}: no points")
    table = np.array(values)  # (m, columns)
    points = table[:, [names.index(axis) for axis in "xyz"]]
    times = table[:, names.index("t")] if "t" in names else np.arange(len(table)) / rate
    times = times - times[0]
    if (np.diff(times) <= 0.0).any():
        line = int(np.flatnonzero(np.diff(times) <= 0.0)[0]) + 3
        raise PathError(f"{path}: line {line}: t does not grow")
    return TargetPath(times, points, repeats)


def _numbers(path: Path, line: int, row: list[str], names: list[str]) -> list[float]:
    if len(row) != len(names):
        raise PathError(f"{path}: line {line}: found {len(row)} values, expected {len(names)}")
    try:
        values = [float(text) for text in row]
    except ValueError as error:
        raise PathError(f"{path}: line {line}: {error}") from error
    if not np.isfinite(values).all():
        raise PathError(f"{path}: line {line}: {', '.join(row)} is not finite")
    return values
