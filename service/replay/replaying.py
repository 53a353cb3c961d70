"""Replay: run the controller again on the goals of a log and compare its actuation.

Time is counted in the log's ticks, without a clock: each tick contains the goal of its decision, so the
result does not depend on the speed of the machine.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from time import perf_counter

import numpy as np

from tauten.controller import Order, warm_controller
from tauten.controller.qpcc import Status, write_qpcc
from tauten.model import Actuators, EffectorLayout, Robot, one_blas_thread
from tauten.model.contact import ObstaclePose
from tauten.model.numerics import Array
from tauten.service.describing import describe
from tauten.service.log import LogError, LogReader
from tauten.service.node import Action, ControlLoop
from tauten.service.replay.recorded_setup import recorded_setup
from tauten.service.setup import Setup
from tauten.service.wire import (
    CDR,
    JSON,
    Cause,
    Joints,
    Keys,
    LockOrder,
    Mode,
    OperatorCommand,
    OperatorOrder,
    Rejection,
    RunDescription,
    Tick,
    decode_command,
    decode_joints,
    decode_obstacle,
    decode_tick,
)

log = logging.getLogger(__name__)

CHANGED = (
    "the robot has changed since the log was made, this is the robot as it is now: put the recorded robot "
    "file beside the log, or name the robot with --against"
)


@dataclass(frozen=True, slots=True)
class Courses:
    """Recorded and replayed actuation, tick by tick.

    Attributes:
        time: (m,) of the ticks, from the first one [s].
        position: (2, m, n_a) positions, recorded and replayed [m, m³].
        effort: (2, m, n_a) efforts, recorded and replayed [N, Pa].
        status: of the decisions, recorded and replayed, "" where nothing was decided.
    """

    time: Array
    position: Array
    effort: Array
    status: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Replay:
    """The difference between a replay and its log.

    Attributes:
        actuators: of the robot.
        courses: every tick.
        seconds: duration of the replay.
        position: (n_a,) largest difference of positions [m, m³].
        effort: (n_a,) largest difference of efforts [N, Pa].
        fraction: largest difference as a fraction of the actuator's range.
        worst_tick: tick of that difference.
        statuses: ticks whose decision ended with another status.
        tolerance: fraction that is accepted.
        notes: other changes since the log was made.
        mesh_error: of the robot that replayed it, in one sentence.
    """

    actuators: Actuators
    courses: Courses
    seconds: float
    position: Array
    effort: Array
    fraction: float
    worst_tick: int
    statuses: int
    tolerance: float
    notes: tuple[str, ...]
    mesh_error: str

    @property
    def ticks(self) -> int:
        """Number of ticks that were compared."""
        return len(self.courses.time)

    @property
    def speed(self) -> float:
        """Duration of the run over the duration of the replay."""
        return float(self.courses.time[-1]) / self.seconds

    @property
    def same(self) -> bool:
        """Whether the controller decided the same, within the tolerance."""
        return self.fraction <= self.tolerance and self.statuses == 0


def replay(
    path: Path,
    tolerance: float,
    against: str | None = None,
    model: Order | None = None,
    recorded_paths: bool = False,
) -> Replay:
    """Run the controller on a log.

    Args:
        path: MCAP file that `tauten serve --record` or `tauten demo` made.
        tolerance: accepted difference as a fraction of each cable's range of pull and tension.
        against: robot to use instead of the recorded one, a name or a file.
        model: model to use instead of the recorded one.
        recorded_paths: open the robot file and the basis at the paths that the log names, also where
            these are not beside the log.

    Raises:
        LogError: no log, a damaged one, or none that fits the robot.
        RobotFileError, MeshError, BasisError, StateBasisError: the robot cannot be used.
    """
    reader = LogReader(path)
    metadata = reader.read_metadata()
    recorded = recorded_setup(path, metadata)
    setup = recorded.load(against, model, recorded_paths)
    if against is None and has_changed(recorded.description, setup.robot):
        log.warning("%s: %s", path, CHANGED)
    with one_blas_thread():
        return _compare(reader, setup, recorded.description, tolerance)


def write_problem(path: Path, index: int, file: Path, recorded_paths: bool = False) -> None:
    """Write the inverse problem of a recorded tick to a file for `tauten solve`.

    Raises:
        LogError: no log, a damaged one, none that fits the robot, or nothing was decided in this tick.
        RobotFileError, MeshError, BasisError, StateBasisError: the robot cannot be used.
        OSError: the file cannot be written.
    """
    reader = LogReader(path)
    recorded = recorded_setup(path, reader.read_metadata())
    setup = recorded.load(allowed=recorded_paths)
    with one_blas_thread():
        loop = replay_loop(setup)
        for tick, _, _ in actions(recorded_ticks(reader, setup, recorded.description.name), loop):
            decision = loop.controller.last_decision
            if tick.index != index or not tick.goal_values or decision is None:
                continue
            if decision.problem is not None:
                write_qpcc(file, decision.problem, decision.start)
                return
    raise LogError(f"{path}: tick {index} is not in the log, or no decision was made in it")


@dataclass(frozen=True, slots=True)
class RecordedTick:
    """A tick of a log.

    Attributes:
        tick: as it was published.
        actuation: that left in it.
        orders: of the operator that were read in it, oldest first, possible or not.
        obstacles: where those are after it whose poses may arrive.
    """

    tick: Tick
    actuation: Joints
    orders: tuple[OperatorOrder, ...] = ()
    obstacles: Mapping[str, ObstaclePose] = field(default_factory=dict)


def recorded_ticks(reader: LogReader, setup: Setup, robot: str) -> Iterator[RecordedTick]:
    """Ticks of a log, each with its actuation.

    Raises:
        LogError: a message that does not fit the robot.
    """
    keys, count = Keys(robot), 0
    actuation: Joints | None = None
    orders: list[tuple[int, OperatorOrder]] = []
    found = setup.robot.obstacles.obstacles
    posed = {keys.obstacle_state(one.name): one.name for one in found if one.stream is not None}
    placed = dict[str, ObstaclePose]()
    for message in reader.messages():
        if message.key == keys.actuation:
            joints = decode_joints(message.payload, CDR, setup.robot.actuators.names)
            if isinstance(joints, Rejection):
                raise LogError(f"{reader.path}: does not fit the robot: {joints.detail}")
            actuation = joints
        elif message.key == keys.command:
            order = decode_command(message.payload, JSON if message.encoding == "json" else CDR)
            if not isinstance(order, Rejection):
                orders.append((message.sequence, order))
        elif message.key in posed:
            placed[posed[message.key]] = _pose_of(message.payload, reader.path)
        elif message.key == keys.tick and actuation is not None:
            tick = decode_tick(message.payload)
            if isinstance(tick, Rejection):
                raise LogError(f"{reader.path}: a damaged tick: {tick.detail}")
            _check_goal(tick, setup.robot.effector_layout, reader.path)
            if tick.index != count:
                raise LogError(f"{reader.path}: ticks {count} to {tick.index - 1} are missing")
            count += 1
            read = tuple(order for when, order in orders if when <= tick.index)
            orders = [item for item in orders if item[0] > tick.index]
            yield RecordedTick(tick, actuation, read, placed)
            placed = {}


def _pose_of(payload: bytes, path: Path) -> ObstaclePose:
    """Where the model had an obstacle."""
    state = decode_obstacle(payload)
    if isinstance(state, Rejection):
        raise LogError(f"{path}: a damaged pose of an obstacle: {state.detail}")
    return state.pose


def _check_goal(tick: Tick, layout: EffectorLayout, path: Path) -> None:
    """Goal and correction of a tick: none, or those of all effectors, finite."""
    for what, positions, values, expected in (
        ("goals", tick.goal, tick.goal_values, layout.n_values),
        ("corrections", tick.correction, tick.correction_values, layout.n_rows),
    ):
        if positions and len(positions) != len(layout):
            raise LogError(
                f"{path}: tick {tick.index}: {what} for {len(positions)} effectors, "
                f"the robot has {len(layout)}"
            )
        if len(values) not in (0, expected):
            raise LogError(
                f"{path}: tick {tick.index}: {what} of {len(values)} values, the robot's effectors "
                f"have {expected}"
            )
        # where a model is no number, so is the goal of its effectors that have no target
        known = tick.status != Status.NOT_FINITE.name or what != "goals"
        if known and not all(map(isfinite, values)):
            raise LogError(f"{path}: tick {tick.index}: {what} that are not finite")
    finite = all(map(isfinite, tick.goal_values))
    if finite and tick.goal_values and layout.checked(np.array(tick.goal_values)) is None:
        raise LogError(f"{path}: tick {tick.index}: a goal that is no rotation")
    if tick.correction_values and not tick.goal_values:
        raise LogError(f"{path}: tick {tick.index}: a correction without a goal")


def replay_loop(setup: Setup) -> ControlLoop:
    """A loop at the start of a run, with every kernel compiled.

    Raises:
        LogError: the run started from an equilibrium, and the model finds none.
    """
    controller = warm_controller(setup)
    if setup.start == "settled" and not controller.settled:
        raise LogError(
            f"the run started from an equilibrium under the loads, which {setup.robot.name} no longer finds"
        )
    return ControlLoop(controller, settings=setup.service)


def actions(
    ticks: Iterator[RecordedTick], loop: ControlLoop
) -> Iterator[tuple[Tick, Joints, Action]]:
    """Actions of a loop at the recorded ticks."""
    for recorded in ticks:
        tick, actuation = recorded.tick, recorded.actuation
        for order in recorded.orders:
            if order is OperatorCommand.RESET and tick.mode is not Mode.STOP:
                _rest_after_stop(loop)
            elif isinstance(order, LockOrder) or order is OperatorCommand.LET_GO:
                loop.obey(order)  # refused as it was in the run
        if tick.mode is not Mode.STOP:
            _rest_after_stop(loop)
        # also where the decision could not be used
        mode = Mode.RUN if tick.goal_values else tick.mode
        loop.set_mode(mode, tick.cause)
        goal = np.array(tick.goal_values) if tick.goal_values else None
        if goal is not None and tick.correction_values:
            layout = loop.controller.robot.effector_layout
            goal = layout.moved(goal, np.array(tick.correction_values))
        action = loop.act(goal, tick.checks)
        loop.prepare(recorded.obstacles)
        yield tick, actuation, action


def _rest_after_stop(loop: ControlLoop) -> None:
    """Do what an operator's reset does to a loop that has stopped."""
    if loop.state.mode is Mode.STOP:
        loop.rest()
        loop.set_mode(Mode.IDLE, Cause.NO_TARGET)


def _compare(
    reader: LogReader, setup: Setup, description: RunDescription, tolerance: float
) -> Replay:
    begin = perf_counter()
    courses = _courses(recorded_ticks(reader, setup, description.name), setup)
    if len(courses.time) == 0:
        raise LogError(f"{reader.path}: no tick to replay")
    seconds = perf_counter() - begin
    limits = setup.robot.limits
    off_position = np.abs(courses.position[1] - courses.position[0])  # (m, n_a)
    off_effort = np.abs(courses.effort[1] - courses.effort[0])  # (m, n_a)
    shares = np.maximum(
        off_position / (limits.position_max - limits.position_min),
        off_effort / limits.largest_effort,
    ).max(axis=1)  # (m,)
    return Replay(
        actuators=setup.robot.actuators,
        courses=courses,
        seconds=seconds,
        position=off_position.max(axis=0),
        effort=off_effort.max(axis=0),
        fraction=float(shares.max()),
        worst_tick=int(shares.argmax()),
        statuses=sum(before != now for before, now in courses.status),
        tolerance=tolerance,
        notes=tuple(changes(reader, description, setup)),
        mesh_error=setup.mesh_error,
    )


def _courses(recorded: Iterator[RecordedTick], setup: Setup) -> Courses:
    stamps, status = [], []
    position: list[tuple[Array, Array]] = []
    effort: list[tuple[Array, Array]] = []
    for tick, actuation, action in actions(recorded, replay_loop(setup)):
        stamps.append(tick.stamp)
        position.append((np.array(actuation.position), action.actuation.position))
        effort.append((np.array(actuation.effort), action.actuation.effort))
        status.append((tick.status, "" if action.status is None else action.status.name))
    time: Array = 1e-9 * (np.array(stamps) - stamps[0] if stamps else np.zeros(0))
    shape = (len(stamps), 2, setup.robot.n_a)
    return Courses(
        time=time,
        position=np.array(position).reshape(shape).swapaxes(0, 1),
        effort=np.array(effort).reshape(shape).swapaxes(0, 1),
        status=tuple(status),
    )


def has_changed(then: RunDescription, robot: Robot) -> bool:
    """Whether the robot of a log is another one now: its model, or the effectors that goals are for."""
    kinds = tuple(one.kind for one in then.effectors)
    return then.model.digest != robot.digest or kinds != robot.effector_layout.kinds


def changes(reader: LogReader, then: RunDescription, setup: Setup) -> Iterator[str]:
    """What has changed since a log was made, a sentence each; once all its messages have been read."""
    if not reader.complete:
        yield "the log was cut short"
    now = describe(setup)
    file = setup.path.read_text(encoding="utf-8")
    for name, before, after in (
        ("robot digest", then.model.digest, now.model.digest),
        ("robot file", reader.metadata.get("robot_file", ""), file),
        ("basis digest", then.basis.digest, now.basis.digest),
        ("states digest", then.model.states, now.model.states),
        ("factorisation", then.model.factorisation, now.model.factorisation),
    ):
        if before != after:
            yield f"{name} has changed"
