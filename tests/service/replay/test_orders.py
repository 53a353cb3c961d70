"""A replay decides as the run did, whatever an operator ordered and in whichever mode."""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from support.messages import tick_of

from tauten.controller import Controller
from tauten.model import Robot
from tauten.service.node import Action, ControlLoop, Signals
from tauten.service.replay import actions
from tauten.service.replay.replaying import RecordedTick
from tauten.service.settings import ServiceSettings
from tauten.service.wire import Joints, LockOrder, Mode, OperatorCommand, OperatorOrder

TICKS = 250
SETTINGS = ServiceSettings(release_time=0.2)


def ordered(rnd: random.Random, robot: Robot, stopped: bool) -> tuple[OperatorOrder, ...]:
    """What an operator orders in a tick, possible or not; of a stopped robot mostly a reset, and a lock."""
    name = rnd.choice(robot.actuators.names)
    some: list[OperatorOrder] = [
        *OperatorCommand, OperatorCommand.ENABLE,
        LockOrder(name, position=rnd.uniform(0.0, 0.005)), LockOrder(name, force=rnd.uniform(0.0, 2.0)),
        LockOrder(name),
    ]  # fmt: skip
    found = rnd.choices(some, k=rnd.choice((1, 1, 2))) if rnd.random() < 0.12 else []
    if stopped and rnd.random() < 0.2:
        lock = LockOrder(name, position=rnd.uniform(0.001, 0.005))
        found += [OperatorCommand.RESET, lock, OperatorCommand.ENABLE]
    return tuple(found)


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_a_replay_decides_as_the_run_did_whatever_was_ordered(beam: Robot, seed: int) -> None:
    rnd, recorded, wanted = random.Random(seed), list[RecordedTick](), list[Action]()
    run, again = (ControlLoop(Controller(beam), settings=SETTINGS) for _ in range(2))
    rest, refused = run.controller.effector_values, 0
    goal = rest
    for index in range(TICKS):
        orders = ordered(rnd, beam, run.state.mode is Mode.STOP)
        refused += sum(run.obey(order) is not None for order in orders)
        if rnd.random() < 0.1:
            goal = rest + np.tile([0.0, 0.0, rnd.uniform(-0.01, 0.01)], 2)
        target = rnd.random() < 0.85
        action = run.tick(goal if target else None, Signals(target))
        run.prepare()
        wanted.append(action)
        tick = replace(
            tick_of(action), index=index, cause=action.cause,
            goal_values=tuple(goal.tolist()) if action.decided else (),
        )  # fmt: skip
        left = action.actuation
        joints = Joints(1, "base", beam.actuators.names, tuple(left.position), tuple(left.effort))
        recorded.append(RecordedTick(tick, joints, orders))
    modes = Counter(one.mode for one in wanted)
    assert refused > 3 and modes[Mode.RUN] > 50, (refused, modes)
    assert modes[Mode.HOLD] > 10 and modes[Mode.STOP] > 10, modes
    for index, (_, _, found) in enumerate(actions(iter(recorded), again)):
        one, other = found.actuation, wanted[index].actuation
        assert one.position.tolist() == other.position.tolist(), (index, recorded[index])
        assert one.effort.tolist() == other.effort.tolist(), (index, recorded[index])
