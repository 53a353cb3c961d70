"""The shipped finger before a plate with friction, and a target behind it."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.examples import example

from tauten.controller import Controller
from tauten.controller.qpcc import Status

PLATE = example("10_finger_on_plate")["FILE"]


@pytest.mark.long
def test_a_target_far_behind_a_plate_is_no_reason_to_look_for_contact() -> None:
    """The finger stops at the plate: the decisions see that it could move, and end within their budget."""
    controller = Controller.of(PLATE, "reduced")
    rest, statuses, forces = controller.tip, [], []
    for tick in range(40):
        behind = 0.02 + 0.03 * np.sin(np.pi * tick / 100) ** 2  # m
        statuses.append(controller.step(rest + np.array([behind, 0.0, -0.01])).status)
        forces.append(controller.contacts.normal_force.sum())
    assert set(statuses) == {Status.OK}
    assert max(forces) > 1e-3  # N, it has been pressed
