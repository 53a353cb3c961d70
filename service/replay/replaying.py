"""Replay: the controller again, headless, on the goals of a log; does it still decide the same?

Time is the log's ticks, not the clock: each tick carries the goal its decision used, so the result
does not depend on the machine's speed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

import numpy as np

from tauten.model.numerics import Array
from tauten.service.log import LogError, LogReader
from tauten.service.node import Action, ControlLoop
from tauten.service.process import one_blas_thread
from tauten.service.setup import Order, Setup, load_setup, warm_controller
from tauten.service.wire import CDR, Joints, Keys, Mode, Rejection, Tick, decode_joints, decode_tick


@dataclass(frozen=True, slots=True)
class Courses:
    """Recorded and replayed actuation, tick by tick.

    Attributes:
        time: (m,) of the ticks, from the first one [s].
        pull: (2, m, n_a) pulled lengths, recorded and replayed [m].
        tension: (2, m, n_a) tensions, recorded and replayed [N].
        status: of the decisions, recorded and replayed, "" where nothing was decided.
    """

    time: Array
    pull: Array
    tension: Array
    status: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Replay:
    """How far a replay is from its log.

    Attributes:
        cables: names.
        courses: all of it.
        seconds: that the replay took.
        pull: (n_a,) largest difference of pulled lengths [m].
        tension: (n_a,) largest difference of tensions [N].
        fraction: largest difference as a fraction of the cable's range.
        worst_tick: where that was.
        statuses: ticks whose decision ended with another status.
        tolerance: fraction that is accepted.
        notes: what else has changed since the log was made.
    """

    cables: tuple[str, ...]
    courses: Courses
    seconds: float
    pull: Array
    tension: Array
    fraction: float
    worst_tick: int
    statuses: int
    tolerance: float
    notes: tuple[str, ...]

    @property
    def ticks(self) -> int:
        """How many were compared."""
        return len(self.courses.time)

    @property
    def speed(self) -> float:
        """How much faster than the run the replay was."""
        return float(self.courses.time[-1]) / self.seconds

    @property
    def same(self) -> bool:
        """Whether the controller decided the same, within the tolerance."""
        return self.fraction <= self.tolerance and self.statuses == 0


def replay(
    path: Path, tolerance: float, against: str | None = None, model: Order | None = None
) -> Replay:
    """Run the controller on a log.

    Args:
        path: MCAP file that `tauten serve --record` or `tauten demo` made.
        tolerance: accepted difference as a fraction of each cable's range of pull and tension.
        against: robot to use instead of the recorded one, a name or a file.
        model: model to use instead of the recorded one.

    Raises:
        LogError: no log, or none that fits the robot.
        RobotFileError, MeshError, BasisError: the robot cannot be used.
    """
    reader = LogReader(path)
    metadata = reader.read_metadata()
    try:
        rate, basis = float(metadata["rate"]), metadata["basis"]
        name = against or recorded_robot(metadata)
    except (KeyError, ValueError) as error:
        raise LogError(f"{path}: its metadata lack {error}") from error
    recorded: Order = "reduced" if metadata.get("model") == "reduced" else "full"
    setup = load_setup(name, rate, None if against else basis, model or recorded, accept_error=True)
    with one_blas_thread():
        return _compare(reader, setup, metadata, tolerance)


def recorded_robot(metadata: dict[str, str]) -> str:
    """The robot of a log: its file where that still is, else the shipped one of that name."""
    path = Path(metadata["robot_path"])
    return str(path) if path.is_file() else metadata["robot"]


def recorded_ticks(reader: LogReader, setup: Setup, robot: str) -> Iterator[tuple[Tick, Joints]]:
    """Ticks of a log with the actuation that left in each.

    Raises:
        LogError: a message that does not fit the robot.
    """
    keys, count = Keys(robot), 0
    actuation: Joints | None = None
    for message in reader.messages():
        if message.key == keys.actuation:
            joints = decode_joints(message.payload, CDR, setup.robot.cable_names)
            if isinstance(joints, Rejection):
                raise LogError(f"{reader.path}: does not fit the robot: {joints.detail}")
            actuation = joints
        elif message.key == keys.tick and actuation is not None:
            tick = decode_tick(message.payload)
            if isinstance(tick, Rejection):
                raise LogError(f"{reader.path}: a damaged tick: {tick.detail}")
            if tick.goal and len(tick.goal) != len(setup.robot.effector_names):
                raise LogError(f"{reader.path}: goals for {len(tick.goal)} effectors")
            if tick.index != count:
                raise LogError(f"{reader.path}: ticks {count} to {tick.index - 1} are missing")
            count += 1
            yield tick, actuation


def actions(
    ticks: Iterator[tuple[Tick, Joints]], setup: Setup
) -> Iterator[tuple[Tick, Joints, Action]]:
    """What the loop does now at each recorded tick."""
    loop = ControlLoop(warm_controller(setup))
    for tick, actuation in ticks:
        if loop.state.mode is Mode.STOP and tick.mode is not Mode.STOP:
            loop.rest()  # what a reset did
        # a decision that could not be used was one all the same
        mode = Mode.RUN if tick.goal else tick.mode
        loop.state = replace(loop.state, mode=mode, cause=tick.cause)
        goal = np.array(tick.goal) if tick.goal else None
        action = loop.act(goal if not tick.correction else goal + np.array(tick.correction))
        loop.prepare()
        yield tick, actuation, action


def _compare(reader: LogReader, setup: Setup, metadata: dict[str, str], tolerance: float) -> Replay:
    begin = perf_counter()
    courses = _courses(recorded_ticks(reader, setup, metadata["robot"]), setup)
    if len(courses.time) == 0:
        raise LogError(f"{reader.path}: no tick to replay")
    seconds = perf_counter() - begin
    limits = setup.robot.limits
    off_pull = np.abs(courses.pull[1] - courses.pull[0])  # (m, n_a)
    off_tension = np.abs(courses.tension[1] - courses.tension[0])  # (m, n_a)
    shares = np.maximum(
        off_pull / (limits.pull_max - limits.pull_min), off_tension / limits.tension_max
    ).max(axis=1)  # (m,)
    return Replay(
        cables=setup.robot.cable_names,
        courses=courses,
        seconds=seconds,
        pull=off_pull.max(axis=0),
        tension=off_tension.max(axis=0),
        fraction=float(shares.max()),
        worst_tick=int(shares.argmax()),
        statuses=sum(before != now for before, now in courses.status),
        tolerance=tolerance,
        notes=tuple(_changes(reader, setup, metadata)),
    )


def _courses(recorded: Iterator[tuple[Tick, Joints]], setup: Setup) -> Courses:
    stamps, status = [], []
    pull: list[tuple[Array, Array]] = []
    tension: list[tuple[Array, Array]] = []
    for tick, actuation, action in actions(recorded, setup):
        stamps.append(tick.stamp)
        pull.append((np.array(actuation.pull), action.pull))
        tension.append((np.array(actuation.tension), action.tension))
        status.append((tick.status, "" if action.status is None else action.status.name))
    time: Array = 1e-9 * (np.array(stamps) - stamps[0] if stamps else np.zeros(0))
    shape = (len(stamps), 2, setup.robot.n_a)
    return Courses(
        time=time,
        pull=np.array(pull).reshape(shape).swapaxes(0, 1),
        tension=np.array(tension).reshape(shape).swapaxes(0, 1),
        status=tuple(status),
    )


def _changes(reader: LogReader, setup: Setup, metadata: dict[str, str]) -> Iterator[str]:
    if not reader.complete:
        yield "the log was cut short"
    now = setup.metadata()
    for key in ("robot_digest", "robot_file", "basis_digest", "states_digest", "factorisation"):
        if metadata.get(key, "") != now[key]:
            yield f"{key.replace('_', ' ')} has changed"
