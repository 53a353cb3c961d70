"""The legend has what a picture can show, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from tauten.model import skin_of
from tauten.service.describing import describe
from tauten.service.frames import RobotLook
from tauten.service.setup import load_setup
from tauten.service.view.picture import legend_rows


def meanings(robot: str | Path, basis: str | None = None, operated: bool = False) -> set[str]:
    """What the colours of a robot mean that a log or a node describes."""
    setup = load_setup(robot, basis=basis)
    skin = skin_of(setup.robot).geometry(setup.robot, setup.robot.rest(), None)
    look = RobotLook(describe(setup), skin.vertices)
    return {text for _, text in legend_rows(look, operated=operated)}


@pytest.mark.parametrize(("basis", "expected"), [("full", True), ("none", False)])
def test_contact_forces_are_named_where_there_may_be_some(basis: str, expected: bool) -> None:
    assert ("contact force" in meanings("finger", basis)) == expected


def test_a_robot_that_cannot_touch_anything_has_no_contact_forces(beam_file: Path) -> None:
    assert "contact force" not in meanings(beam_file)


def test_waypoints_are_named_where_somebody_operates(beam_file: Path) -> None:
    assert "waypoint" not in meanings(beam_file)
    assert "waypoint" in meanings(beam_file, operated=True)
