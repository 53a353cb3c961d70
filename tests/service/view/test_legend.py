"""The legend has what a picture can show, and nothing else."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from tauten.model import load_robot, skin_of
from tauten.service.describing import describe
from tauten.service.frames import RobotLook
from tauten.service.setup import load_setup
from tauten.service.view.picture import legend_rows
from tauten.service.wire import DescribedObstacle, RobotDescription

EXAMPLES = Path(__file__).parents[3] / "examples"


def meanings(robot: str | Path, basis: str | None = None, operated: bool = False) -> set[str]:
    """What the colours of a robot mean that a log or a node describes."""
    setup = load_setup(robot, basis=basis)
    skin = skin_of(setup.robot).geometry(setup.robot, setup.robot.rest(), None)
    look = RobotLook(describe(setup), skin.vertices)
    return {text for _, text in legend_rows(look, operated=operated)}


@pytest.mark.long
@pytest.mark.parametrize(("basis", "expected"), [("full", True), ("none", False)])
def test_contact_forces_are_named_where_there_may_be_some(basis: str, expected: bool) -> None:
    assert ("contact force" in meanings("finger", basis)) == expected


def test_a_robot_that_cannot_touch_anything_has_no_contact_forces(beam_file: Path) -> None:
    assert "contact force" not in meanings(beam_file)


def test_waypoints_are_named_where_somebody_operates(beam_file: Path) -> None:
    assert "waypoint" not in meanings(beam_file)
    assert "waypoint" in meanings(beam_file, operated=True)


def test_objects_are_named_where_a_part_has_no_actuator(beam_file: Path) -> None:
    assert not any("object" in text for text in meanings(beam_file))
    assert any("object" in text for text in meanings(EXAMPLES / "push.toml"))


def test_the_triangles_of_an_object_are_those_of_its_cube() -> None:
    robot = load_robot(EXAMPLES / "push.toml")
    corners = robot.triangles[robot.body.of_objects]
    points = robot.points(robot.rest())[corners].reshape(-1, 3)
    assert np.allclose(points.max(axis=0) - points.min(axis=0), 0.02)  # a cube of 20 mm
    assert np.allclose((points.max(axis=0) + points.min(axis=0)) / 2.0, [0.0145, 0.0, 0.01])


def test_a_description_names_triangles_of_objects_that_it_has() -> None:
    whole = describe(load_setup(EXAMPLES / "push.toml"))
    assert len(RobotDescription.model_validate_json(whole.as_json()).surface.objects) > 0
    count = len(whole.surface.triangles)
    outside = whole.surface.model_copy(update={"objects": np.array([count])})
    with pytest.raises(ValidationError, match=f"names number {count} of {count}"):
        RobotDescription.model_validate_json(
            whole.model_copy(update={"surface": outside}).as_json()
        )
    for last, refused in ((2, False), (3, True)):
        with pytest.raises(ValidationError, match="3 of 3") if refused else nullcontext():
            DescribedObstacle(name="one", vertices=np.eye(3), triangles=np.array([[0, 1, last]]))
