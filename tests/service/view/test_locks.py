"""The sliders of the actuators: where they are, or where they were told to be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tauten.model import Robot, skin_of
from tauten.service.describing import describe
from tauten.service.frames import RobotLook
from tauten.service.setup import load_setup
from tauten.service.view import open_server
from tauten.service.view.locks import LockPanel


def test_a_slider_stays_where_it_was_put_until_the_node_has_said_what_is_locked(
    beam_file: Path, beam: Robot
) -> None:
    """It returned to where the actuator was, and showed that beside *locked* for as long as it was."""
    vertices = skin_of(beam).geometry(beam, beam.rest(), None).vertices
    look, now = RobotLook(describe(load_setup(beam_file)), vertices), 10.0
    name, still, moved = look.robot.actuators[0].name, np.zeros(2), np.full(2, 3e-3)
    with open_server(0, "test") as (server, _):
        panel = LockPanel(server.gui, look, lambda: now)
        slider, box = panel._sliders[0], panel._boxes[0]

        def shown(position: np.ndarray, *locked: str) -> tuple[float, bool]:
            panel.show(position, frozenset(locked))
            return float(slider.value), bool(box.value)

        def put(millimetres: float, locked: bool = True) -> None:
            """What the operator does."""
            slider.value = millimetres  # type: ignore[misc]
            panel._order(0, locked)

        assert shown(still) == (0.0, False)
        put(5.0)
        (order,) = panel.orders()
        assert (order.actuator, order.position) == (name, pytest.approx(5e-3))
        assert shown(still) == (5.0, True)  # the node has not said so yet
        now += 1.0
        assert shown(moved, name) == (5.0, True)
        now += 5.0
        assert shown(moved, name) == (5.0, True)
        for at in (4e-3, 5e-3, 5e-3):
            assert shown(np.full(2, at), name) == (5.0, True)
        assert shown(np.full(2, 6e-3), name) == (
            6.0,
            True,
        )  # somebody else has locked it farther away
        assert shown(np.full(2, 8e-3), name) == (8.0, True)
        put(5.0, locked=False)
        assert shown(moved, name) == (3.0, False)
        now += 5.0
        assert shown(moved) == (3.0, False)
        put(6.0)  # is refused
        now += 5.0
        assert shown(moved) == (3.0, False)
        assert shown(moved, name) == (3.0, True)  # by somebody else
