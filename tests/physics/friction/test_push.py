"""A finger moves a block through contact alone: given its cable's position, and decided by a controller."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.examples import changed, example

from tauten.controller import Controller
from tauten.controller.qpcc import TimeLimit
from tauten.model import Simulator, load_robot
from tauten.model.load import make_robot
from tauten.model.schema import Changes, read_toml

PUSH = example("11_push")
MASS, FRICTION = 1000.0 * 0.02**3, 0.3
WEIGHT = 9.81 * MASS  # N


def test_a_block_slides_by_what_a_finger_pushes_and_the_floor_takes() -> None:
    """Friction is at its border, against the motion, while the block slides; at rest the forces balance."""
    simulator = Simulator(load_robot(PUSH["FILE"]))
    places = [simulator.tip[0]]
    for step in range(1, 16):
        assert simulator.move(position=[2e-4 * min(step, 10)]).converged
        places.append(simulator.tip[0])
        push, floor = PUSH["pushed"](simulator), PUSH["floor_force"](simulator)
        assert push >= 0.0
        if places[-1] - places[-2] > 2e-4:
            np.testing.assert_allclose(floor[0], -FRICTION * floor[2], rtol=1e-3)
    assert abs(places[1] - places[0]) < 2e-4 < 2e-3 < places[-1] - places[0]
    np.testing.assert_allclose(floor[0], -push, atol=1e-2 * WEIGHT)  # at rest
    assert abs(places[-1] - places[-2]) < 1e-6


@pytest.mark.long
def test_a_lower_rate_with_a_lower_max_rate_throws_nothing(tmp_path: Path) -> None:
    """Actuators go as far in a tick as at 50 Hz; with the file's max_rate the block goes twice as far."""
    file = changed(tmp_path, "push.toml", ("rate = 50.0", "rate = 10.0"))
    changed(tmp_path, "pusher.toml", ("max_rate = 0.02", "max_rate = 0.004"))
    controller = Controller(load_robot(file))
    goal, way, places = controller.effector_values, 0.01, []
    goal[0] += way
    for _ in range(25):
        assert controller.step(goal).status.usable
        places.append(controller.effector_values[0] - goal[0] + way)
    assert 0.8 * way < places[-1] and max(places) < 1.05 * way


def side_by_side(count: int) -> Controller:
    """So many fingers with a block each, 0.3 m apart."""
    one, parts, contacts = read_toml(PUSH["FILE"]), [], []
    for number in range(count):
        for part in one["parts"]:
            x, y, z = part.get("position", [0.0, 0.0, 0.0])
            own = {"name": f"{part['name']}{number}", "position": [x, y + 0.3 * number, z]}
            parts.append({**part, **own})
        for contact in one["contacts"]:
            sides = {key: contact[key] for key in ("candidates", "against")}
            named = {
                key: {**side, "part": f"{side['part']}{number}"}
                for key, side in sides.items()
                if isinstance(side, dict)
            }
            contacts.append({**contact, **named})
    return Controller(
        make_robot({**one, "parts": parts, "contacts": contacts}, PUSH["FILE"], Changes())
    )


@pytest.mark.long
def test_two_fingers_push_as_each_does_alone() -> None:
    """They were planned by one search, in which the one whose target was nearer never moved."""
    ways, both = [0.006, 0.002], []
    for controller, own in ((side_by_side(2), ways), (side_by_side(1), ways[1:])):
        start = controller.effector_values
        for tick in range(12):
            goal = start.copy()
            goal[::3] += np.array(own) * (tick + 1) / 27
            assert controller.step(goal).status.usable
        both.append((controller.position[-1], controller.effector_values[-3] - start[-3]))
    assert both[0] == pytest.approx(both[1], rel=0.05)
    assert both[1][0] > 5e-4


@pytest.mark.long
def test_searches_that_are_cut_go_on_each_where_it_was() -> None:
    """The first finger cannot pull its block back, and its search takes all the time of a tick."""
    controller = side_by_side(2)
    goal = controller.effector_values
    goal[::3] += [-0.006, 0.003]
    for _ in range(8):
        controller.prepare()
        assert controller.decide(goal, TimeLimit(checks=5)).status.usable
        controller.advance()
    assert controller.position[-1] > 1e-4


@pytest.mark.slow
def test_a_controller_brings_a_block_to_its_target() -> None:
    way = 0.006
    *_, simulator = PUSH["push"](load_robot(PUSH["FILE"]), way, 0.6)
    assert abs(simulator.tip[0] - PUSH["START"] - way) < 1e-3
    np.testing.assert_allclose(
        PUSH["floor_force"](simulator)[0], -PUSH["pushed"](simulator), atol=1e-2 * WEIGHT
    )
