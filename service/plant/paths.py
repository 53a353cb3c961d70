"""Paths of targets: shapes that start at rest, what the cables can reach, CSV files."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from tauten.model import Command, Robot, Simulator, State
from tauten.model.numerics import Array
from tauten.model.schema import EffectorKind, cause
from tauten.reduction.campaign import command_range
from tauten.service.plant.waypoints import (
    PathError,
    TargetPath,
    csv_text_path,
    without_sign_changes,
)

log = logging.getLogger(__name__)

Shape = Literal["circle", "line", "figure-eight", "step"]
Plane = Literal["xy", "xz", "yz"]
SHAPES: tuple[Shape, ...] = ("circle", "line", "figure-eight", "step")

_SAMPLES = 720  # of an analytic shape: a chord is then nowhere farther off than 1e-5 of its size
_REACH_SAMPLES = 12  # equilibria of `reach` in half a turn, each takes some control steps to find
_REACH_TURNS = 3
_PERIOD = 10.0  # s, of a pass, unless `reach` needs more:
_SPEED = 0.2  # sizes of a robot that an effector moves in a second of `reach`, at most, in the mean of a pass
_RATE_SHARE = 0.5  # of their largest rate, with which actuators move there at most
_SETTLED = 1e-4  # m; targets need not be exact equilibria
_NEARLY_SETTLED = 1e-3  # m
_MAX_STEPS = 80


@dataclass(frozen=True, slots=True)
class PathSettings:
    """How a path is made.

    Attributes:
        effector: number of the effector it is for.
        rate: points a second of a CSV file without times.
        size: of a shape [m], for a volume [m³]; None: a tenth of the robot's size, for a distance, length or
            volume a tenth of what it is at rest.
        period: seconds of one pass; None: 10, or as many as the robot needs for "reach".
        plane: that a shape lies in.
        fraction: of the largest pull or tension, for "reach".
        repeats: whether a CSV file starts again at its end.
    """

    effector: int = 0
    rate: float = 50.0
    size: float | None = None
    period: float | None = None
    plane: Plane = "xz"
    fraction: float = 0.8
    repeats: bool = False


def make_path(name: str, robot: Robot, settings: PathSettings) -> TargetPath:
    """A path by name: a shape, "reach", or a CSV file.

    Raises:
        PathError: no such path, or one that cannot be made.
    """
    if name == "reach":
        return reach_path(robot, settings)
    layout = robot.effector_layout
    simulator = Simulator(robot, contact="full")
    if name in SHAPES:
        simulator.settle_start()  # where the robot is when it starts
    start = simulator.effector_values[layout.values_of(settings.effector)]
    return path_from(name, layout.kinds[settings.effector], start, robot.size, settings)


def path_from(
    name: str, kind: EffectorKind, start: Array, robot_size: float, settings: PathSettings
) -> TargetPath:
    """A path by name that needs no model: a shape, or a CSV file.

    Args:
        name: of the shape or the CSV file.
        kind: of the effector.
        start: (v,) its goal values at rest.
        robot_size: of the robot [m].
        settings: of the path.

    Raises:
        PathError: no such path, or one that cannot be made.
    """
    for shape in SHAPES:
        if name == shape:
            usual = 0.1 * (robot_size if len(start) > 1 else float(start[0]))
            size = usual if settings.size is None else settings.size
            period = _PERIOD if settings.period is None else settings.period
            path = shape_path(shape, start, size, period, settings.plane)
            return replace(path, kind=kind)
    if not name.endswith(".csv"):
        allowed = ", ".join([*SHAPES, "reach"])
        raise PathError(f"no path {name!r}: allowed are {allowed} and files that end in .csv")
    try:
        text = Path(name).read_text(encoding="utf-8-sig")  # spreadsheets write its mark
    except (OSError, UnicodeDecodeError) as error:
        raise PathError(f"{name}: cannot be read ({cause(error)})") from error
    return csv_text_path(text, name, kind, settings.rate, settings.repeats)


def shape_path(shape: Shape, start: Array, size: float, period: float, plane: Plane) -> TargetPath:
    """A shape that starts and ends at some goal values: of positions, or of one number, which swings.

    Args:
        shape: which.
        start: (v,) where it starts; a quaternion stays the same.
        size: radius of a circle, half width of a figure eight, length of a line or step [m].
        period: seconds of one pass.
        plane: that it lies in; a line and a step go along the first axis of it.
    """
    u, v = np.zeros_like(start), np.zeros_like(start)
    if len(start) == 1:
        u[0] = 1.0
    else:
        u["xyz".index(plane[0])] = v["xyz".index(plane[1])] = 1.0
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


def reach_path(robot: Robot, settings: PathSettings) -> TargetPath:
    """Where an effector gets when the cables are pulled: a path that the robot can follow.

    One cable is pulled and let go once; several are pulled one after another, in turns that grow
    and fade, in the order of the directions they pull the effector to, and other actuators alike. What is
    commanded of each, and how far, says `command_range`. A smooth curve through some equilibria of the
    full-order model with pointwise contact. Where there is no equilibrium under a load, the path goes through
    the last one on the way to it. The path begins and ends where the robot starts.

    Raises:
        PathError: the model finds no equilibrium but that at rest.
    """
    reach, effector, period = command_range(robot), settings.effector, settings.period
    shares = settings.fraction * reach_shares(directions(robot, effector))
    simulator, shortened = Simulator(robot, contact="full"), 0
    layout = robot.effector_layout
    kind = layout.kinds[effector]
    found: dict[bytes, tuple[Array, Array]] = {}  # one cable passes each equilibrium twice
    for share in shares:
        if share.tobytes() not in found:
            if share.any():
                shortened += not _settled_or_shortened(simulator, reach.command(share))
            else:
                simulator.settle_start()
            place = simulator.effector_values[layout.values_of(effector)]
            found[share.tobytes()] = place, simulator.position
    values = np.array([found[share.tobytes()][0] for share in shares])  # (m, v)
    positions = np.array([found[share.tobytes()][1] for share in shares])  # (m, n_a)
    if kind == "frame":
        values[:, 3:] = without_sign_changes(values[:, 3:])
    unit = float(layout.units[layout.rows_of(effector).start])  # metres
    if shortened > 0 and unit * np.ptp(values[:, :3], axis=0).max() < _NEARLY_SETTLED:
        raise PathError(f"reach: {robot.name} finds no equilibrium but that at rest")
    if shortened > 0:
        log.warning(
            "reach: %s has no equilibrium under %d of %d loads, which were shortened",
            robot.name, shortened, len(found),
        )  # fmt: skip
    from scipy.interpolate import CubicSpline  # takes long, and only this path needs it

    if period is None:
        period = _unhurried(robot, unit * values[:, :3], positions)
    knots = np.linspace(0.0, period, len(values))
    times = np.linspace(0.0, period, _SAMPLES + 1)
    curve = CubicSpline(knots, values, bc_type="periodic")(times)
    if kind == "frame":
        curve[:, 3:] /= np.linalg.norm(curve[:, 3:], axis=1, keepdims=True)
    return TargetPath(times, curve, True, kind)


def _unhurried(robot: Robot, places: Array, positions: Array) -> float:
    """Whole seconds for a pass, at least 10, in which a robot can follow points at equal intervals.

    An effector moves by `_SPEED` of the size of the robot a second, in the mean, and no actuator faster than
    `_RATE_SHARE` of its largest rate.

    Args:
        robot: its size and the rates of its actuators are used.
        places: (m, 3 or 1) of the effector [m].
        positions: (m, n_a) of the actuators there [m].
    """
    way = float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
    moved = np.abs(np.diff(positions, axis=0)).max(axis=0)  # (n_a,) in an interval
    at_rate = (len(positions) - 1) * float((moved / robot.limits.rate).max())  # s
    return float(np.ceil(max(_PERIOD, way / (_SPEED * robot.part_size), at_rate / _RATE_SHARE)))


def _settled_or_shortened(simulator: Simulator, command: Command) -> bool:
    """Settle under a command, from the load before; whether that is nearly the whole load."""
    before = simulator.state, simulator.forces
    held = command.position, command.effort
    report = simulator.settle(*held, _SETTLED, _MAX_STEPS, load_steps=False)
    if report.movement < _NEARLY_SETTLED:
        return True
    simulator.start_from(*before)
    return simulator.settle(*held, _SETTLED, _MAX_STEPS).converged


def bending_command(robot: Robot) -> Command:
    """The command that bends a robot as far as its first actuator can.

    Each actuator gets as much of its range as it moves the first effector into the direction of the first
    one; cables on the other side get nothing.
    """
    return command_range(robot).command(np.cos(directions(robot, 0)))


def directions(robot: Robot, effector: int) -> Array:
    """Into which direction each cable pulls an effector at rest, seen in the plane they move it in
    most, from the first cable's: (n_a,) [rad]. A distance, length or volume has two: more and less.
    """
    moved = moved_by_actuators(robot, robot.rest(), effector)  # (3 or 1, n_a)
    plane = np.linalg.svd(moved)[0][:, :2]  # (3, 2) or (1, 1)
    x, y = np.vstack([plane.T @ moved, np.zeros((2 - plane.shape[1], len(moved.T)))])
    angle = np.arctan2(y, x)
    turned: Array = (angle - angle[0]) % (2.0 * np.pi)
    return turned


def place_rows(robot: Robot, effector: int) -> slice:
    """Rows of an effector's position, of a frame without its rotation; else the row of its number."""
    own = robot.effector_layout.rows_of(effector)
    return slice(own.start, min(own.stop, own.start + 3))


def moved_by_actuators(robot: Robot, state: State, effector: int) -> Array:
    """How each actuator moves an effector's place, to first order: (3 or 1, n_a) [m/N], all over h² [s²]."""
    robot = robot.fork()
    system = robot.static_system(state)
    rows, place = robot.rows(state, contacts=False), place_rows(robot, effector)
    moved: Array = rows.effectors.dense()[place] @ system.solve(rows.actuators.dense().T)
    return moved


def reach_shares(angles: Array) -> Array:
    """Shares −1 to 1 of the ranges of the actuators on the way of `reach`, zero at both ends: (m, n_a).

    Angles (n_a,) are the directions into which each moves the effector [rad].
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
