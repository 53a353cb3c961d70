"""*reach* is for effectors with a position: others have none to show."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from support.processes import ROBOT, write_robot

from tauten.service.frames import ReachSet, SimulatedRobot
from tauten.service.setup import load_setup
from tauten.service.view import open_server
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
