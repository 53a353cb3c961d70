"""*reach* is for effectors with a position: others have none to show, but a slider."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.messages import effector
from support.processes import ROBOT, write_robot

from tauten.service.frames import ReachSet, SimulatedRobot, TargetStore
from tauten.service.setup import load_setup
from tauten.service.view import open_server
from tauten.service.view.panel import ViewPanel
from tauten.service.view.session import ViewSession

TIP, SPAN = (
    """[[effectors]]
name = "tip"
point = [0.1, 0.01, 0.01]

""",
    """[[effectors]]
name = "span"
kind = "distance"
point = [0.1, 0.01, 0.018]
other = [0.05, 0.01, 0.018]
""",
)


class Asked:
    """A search that notes for which effectors it is asked."""

    def __init__(self) -> None:
        self.effectors = list[int]()

    def of(self, effector: int) -> ReachSet:
        self.effectors.append(effector)
        return ReachSet(points=np.zeros((1, 3)), wanted=2)


def robot_of(folder: Path, effectors: str) -> SimulatedRobot:
    text = ROBOT.split("[[effectors]]", maxsplit=1)[0] + effectors
    file = write_robot(folder, text)
    return SimulatedRobot(load_setup(file), load_setup(file))


def test_reach_is_asked_for_positions_only(tmp_path: Path) -> None:
    asked: Any = Asked()
    with open_server(0, "test") as (server, guard):
        session = ViewSession(robot_of(tmp_path, TIP + SPAN), server, guard, reach=asked)
        box, chosen = session._panel.viewing._reach, session.program._effector
        assert box is not None and chosen is not None
        box.value = True  # type: ignore[misc]
        session._show_reach(None)
        assert (asked.effectors, box.disabled, box.label) == ([0], False, "reach 1/2")
        chosen.value = "span"  # type: ignore[misc]
        session._show_reach(None)
        assert (asked.effectors, box.disabled, box.label) == ([0], True, "reach")
        assert "/reach" not in server.scene._handle_from_node_name
        chosen.value = "tip"  # type: ignore[misc]
        session._show_reach(None)
        assert (asked.effectors, box.disabled) == ([0, 0], False)


def test_there_is_no_box_without_a_position(tmp_path: Path) -> None:
    asked: Any = Asked()
    with open_server(0, "test") as (server, guard):
        session = ViewSession(robot_of(tmp_path, SPAN), server, guard, reach=asked)
        assert session._panel.viewing._reach is None
        session._show_reach(None)
        assert asked.effectors == []


def test_targets_of_one_number_have_a_slider_in_percent_or_millimetres(tmp_path: Path) -> None:
    """The page ended in a division by zero where the function of another package is zero at rest."""
    look = robot_of(tmp_path, SPAN).look
    effectors = (*look.robot.effectors, effector("height", "function", 0.0))
    look = replace(look, robot=look.robot.model_copy(update={"effectors": effectors}))
    (rest,) = effectors[0].rest
    with open_server(0, "test") as (server, _):
        panel = ViewPanel(server, look, TargetStore(effectors, look.robot.size))
        sliders = [slider for slider, _ in panel._scalars.values()]
        assert [one.label for one in sliders] == ["span [%]", "height [mm]"]
        assert [one.value for one in sliders] == pytest.approx([100.0, 0.0])
        panel.show_scalars(np.array([1.1 * rest, -0.004]), look)
        assert [one.value for one in sliders] == pytest.approx([110.0, -4.0])
