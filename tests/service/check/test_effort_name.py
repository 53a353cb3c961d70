"""What `tauten check` calls the efforts of a robot's actuators."""

from __future__ import annotations

from tauten.model import load_robot
from tauten.service.check import CheckSettings, Variant, robot_check
from tauten.service.check.mesh_error import errors_in_words
from tauten.service.process import StopFlag


def test_the_effort_of_a_chamber_is_no_tension() -> None:
    assert errors_in_words(0.026, 2e-4, None, "pressure") == ["pressure +2.6 %", "tip 0.20 mm"]
    robot = load_robot("pneumatic_finger")
    settings, stop = CheckSettings("pneumatic_finger", (0.5,), 0), StopFlag()
    stop.request()
    variants = (Variant("linear", 0), Variant("quadratic", 0))
    found = robot_check.compare_meshes(
        settings, robot, variants, lambda _: robot, stop, lambda _share, _what: None
    )
    assert found.effort_name == "pressure"
