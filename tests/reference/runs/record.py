"""Records the runs of finger and manipulator that `test_recorded_runs.py` replays.

    python tests/reference/runs/record.py [FOLDER]

In logical time, so that a log does not depend on the machine that made it: idle, follow a path that the
cables can pull, hold, follow in closed loop with a robot that is stiffer than its model, let go.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

from tauten.controller import warm_controller
from tauten.model import Simulator, load_robot, one_blas_thread
from tauten.service.describing import log_metadata
from tauten.service.log import Entry, LogRecorder
from tauten.service.node import Action, ControlLoop, Signals, own_estimator
from tauten.service.setup import Setup, load_setup
from tauten.service.wire import (
    JOINTS,
    TICK,
    Joints,
    Keys,
    Positions,
    Tick,
    encode_joints,
    encode_tick,
)

RUNS = {"finger": (0.95, 4.0), "manipulator": (0.2, 2.0)}  # share of the largest pull, seconds
STIFFER = 1.15
IDLE, HOLD, STOP = 0.05, 0.45, 0.95  # shares of the run at which these begin; HOLD lasts as IDLE
START = 1_700_000_000 * 10**9  # ns


def points(values: np.ndarray) -> Positions:
    return tuple((x, y, z) for x, y, z in values.reshape(-1, 3).tolist())


def write(
    recorder: LogRecorder,
    setup: Setup,
    index: int,
    action: Action,
    goal: np.ndarray | None,
    correction: np.ndarray,
) -> None:
    """One tick as the node records it, its times made up."""
    robot, keys = setup.robot, Keys(setup.robot.name)
    stamp = START + round(index * 1e9 * robot.h)
    position, effort = (
        tuple(action.actuation.position.tolist()),
        tuple(action.actuation.effort.tolist()),
    )
    joints = Joints(stamp, robot.frame, robot.actuators.names, position, effort)
    decided = action.decided
    certificate = action.actuation.certificate
    wanted = goal if goal is not None and decided else np.zeros(0)
    moved = correction if wanted.size and correction.any() else np.zeros(0)
    tick = Tick(
        stamp, robot.frame, index, action.mode, action.cause,
        action.status.name if action.status is not None else "", points(wanted), points(moved),
        0, 0.0, math.nan, 1e-3, 8e-3, 1e-2, 0, certificate.deepest_gap,
        certificate.complementarity, certificate.stationarity, certificate.extra_columns,
        action.actuation.clamped, tuple(wanted.ravel().tolist()), tuple(moved.ravel().tolist()),
    )  # fmt: skip
    for key, kind, payload in (
        (keys.actuation, JOINTS, encode_joints(joints)),
        (keys.tick, TICK, encode_tick(tick)),
    ):
        recorder.write(Entry(key, kind, payload, stamp, stamp, index))


def record(name: str, folder: Path) -> Path:
    """Run a robot; returns its log."""
    share, seconds = RUNS[name]
    setup = load_setup(name)
    robot, path = setup.robot, folder / f"{name}.mcap"
    # the path of the file is left out; the robot is found by its name
    recorder = LogRecorder(path, {**log_metadata(setup), "robot_path": ""})
    ticks = round(seconds / robot.h)
    targets = reached(setup, share, ticks)
    loop = ControlLoop(warm_controller(setup), settings=setup.service)
    plant = Simulator(load_robot(name, young_scale=STIFFER), "full")
    plant.settle_start()
    feedback = own_estimator(robot, setup.service)
    for index in range(ticks):
        done = index / ticks
        following = done >= IDLE and not HOLD <= done < HOLD + IDLE
        goal = targets[index] if following else None
        goal_of_model = None if goal is None else goal + feedback.correction
        action = loop.tick(goal_of_model, Signals(following, shutdown=done >= STOP))
        write(recorder, setup, index, action, goal, feedback.correction)
        loop.prepare()
        plant.step(effort=action.actuation.effort)
        if done > HOLD:
            feedback.update(loop.controller.effector_values, plant.effector_values, robot.h)
    recorder.close()
    return path


def reached(setup: Setup, share: float, ticks: int) -> np.ndarray:
    """Goal values (s, n_v) of a controller's own model whose cables are pulled and let go in turns."""
    robot = setup.robot
    simulator, found = Simulator(robot, setup.contact), []
    lag = 2.0 * np.pi * np.arange(robot.n_a) / robot.n_a
    for index in range(ticks):
        phase = 2.0 * np.pi * index / ticks
        swing = 0.5 * (1.0 - np.cos(phase))
        turn = np.ones(1) if robot.n_a == 1 else np.maximum(np.cos(2.0 * phase - lag), 0.0)
        simulator.step(position=share * swing * turn * robot.limits.position_max)
        found.append(simulator.effector_values)
    return np.array(found)


def main() -> None:
    """Record all."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    with one_blas_thread():
        for name in RUNS:
            path = record(name, folder)
            print(f"{path}: {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
