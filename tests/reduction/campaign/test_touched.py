"""A robot that spheres press: where they stand, how hard it pushes, and its snapshots without them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.short_arm import write_short_arm
from support.robots.thumb import write_thumb

from tauten.model import Simulator, load_robot
from tauten.model.load import load_part
from tauten.model.numerics import Array
from tauten.model.schema import RobotFileError, read_toml, same_but_contacts
from tauten.reduction.campaign import (
    Design,
    Run,
    TouchedRobot,
    exploring,
    of_plain_robot,
    pressed_by,
    pressed_columns,
    run_campaign,
    touched_robot,
)
from tauten.reduction.campaign.touched import touching_surfaces

CLAW = Path("examples/claw.toml")


@pytest.fixture(scope="module")
def claw() -> TouchedRobot:
    """The gripper of the lift: the file names the inside of its fingers, and nothing that touches them."""
    found = touched_robot(CLAW)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def design(claw: TouchedRobot) -> Design:
    return exploring(claw.robot, 0, claw)


def centres_in_the_way(design: Design) -> list[tuple[Run, Array]]:
    """Runs with spheres in the way, and the centres (k, 3) of all spheres in each [m]."""
    every = [
        (run, run.pressed[:, 0].reshape(-1, 3)) for run in design.runs if run.pressed is not None
    ]
    return [(run, centres) for run, centres in every if centres[:, 2].max() > -1.0]


def test_surfaces_that_touch_what_is_not_in_the_file(claw: TouchedRobot, tmp_path: Path) -> None:
    assert claw.surfaces == ("inside",)
    thumb = write_thumb(tmp_path)
    assert touched_robot(thumb) is None  # its surfaces touch each other
    contents = read_toml(thumb)
    plane = {"point": [0.0, 0.0, -1.0], "normal": [0.0, 0.0, 1.0]}
    contents["obstacles"] = [{"name": "floor", "shape": "plane", "parameters": plane}]
    contents["contacts"].append({"against": "floor"})
    assert touching_surfaces(load_part(contents, thumb).file) == ("skin",)
    assert touched_robot(Path("examples/lift.toml")) is None  # a robot of parts
    with pytest.raises(RobotFileError, match="surface 'outside' is not defined, known are"):
        touched_robot(CLAW, ["outside"])


def test_places_on_beams_are_on_their_surface(tmp_path: Path) -> None:
    robot = touched_robot(write_short_arm(tmp_path), ["disc2", "feet2"])
    assert robot is not None
    rest = robot.robot.effector(robot.robot.rest())[1:]  # after the tip
    np.testing.assert_allclose(rest, robot.places, atol=1e-12)


def test_the_robot_is_the_same_but_for_contacts(claw: TouchedRobot) -> None:
    assert same_but_contacts(claw.plain.digest, claw.robot.digest)
    assert (claw.plain.n_c, claw.own) == (0, 0)
    assert len(claw.robot.effector_names) == len(claw.places)
    at_rest = claw.robot.effector(claw.robot.rest())
    np.testing.assert_allclose(at_rest, claw.places, atol=1e-9)
    # the inside of the two fingers, which look at each other
    np.testing.assert_allclose(np.abs(claw.normals[:, 1]), 1.0)
    assert (claw.normals[:, 1] * claw.places[:, 1] < 0.0).all()


def test_spheres_are_not_in_the_robot_at_rest_and_stand_in_its_way(
    claw: TouchedRobot, design: Design
) -> None:
    found = centres_in_the_way(design)
    assert len(found) == 34
    for _, centres in found:
        for centre, radius in zip(centres, claw.radii, strict=True):
            gap = np.linalg.norm(claw.vertices - centre, axis=1).min() - radius
            assert gap >= -1e-12
            assert gap < claw.robot.size or centre[2] < -1.0


def test_actuators_push_the_robot_against_a_sphere(claw: TouchedRobot, design: Design) -> None:
    """At equilibrium no vertex is in it; friction and normal forces balance on what holds the robot."""
    simulator = Simulator(claw.robot, "full")
    run, centres = centres_in_the_way(design)[0]
    simulator.set_obstacles(pressed_by(simulator.obstacles, centres.ravel()))
    assert run.effort is not None
    report = simulator.settle(run.position[:, -1], run.effort[:, -1])
    assert report.converged
    pushed = simulator.contacts
    size = np.linalg.norm(pushed.force, axis=1)
    assert 0.1 < size.sum() < 20.0  # of the order of the tension that closes the fingers
    assert size.sum() < 3.0 * np.abs(simulator.effort[0])
    touching = simulator.robot.candidates(simulator.state)
    inside = []
    slot = claw.plain.n_c
    for centre, radius in zip(centres, claw.radii, strict=True):
        count = (claw.robot.n_c - claw.plain.n_c) // len(claw.radii)
        apart = np.linalg.norm(touching[slot : slot + count] - centre, axis=1)
        inside.append((radius - apart).max())
        slot += count
    assert -1e-4 < max(inside) < claw.robot.tolerance


@pytest.mark.long
def test_snapshots_without_spheres_are_those_of_the_plain_robot(
    claw: TouchedRobot, design: Design, tmp_path: Path
) -> None:
    free, pressed = design.runs[0], design.runs[-1]
    short = Design("two", (free.piece(0, 2), pressed.piece(0, 2)))
    found = run_campaign(claw.robot, short, tmp_path)
    assert found.converged.all()
    np.testing.assert_array_equal(pressed_columns(claw.robot, found), [False, False, True, True])
    own = of_plain_robot(claw, found)
    assert len(own) == 2
    assert (len(own.lam), len(own.effector), len(own.pressed)) == (0, 0, 0)
    # and they are: the plain robot comes to the same places
    simulator = Simulator(load_part(read_toml(CLAW), CLAW).robot)
    assert free.effort is not None
    for i in range(2):
        assert simulator.settle(free.position[:, i], free.effort[:, i], 1e-8).converged
    np.testing.assert_allclose(simulator.state.q, own.q[:, 1], atol=1e-6)


def test_one_actuator_presses_all_over_its_range(tmp_path: Path) -> None:
    """Corners of the ranges are for several: half of the runs ended at the one end that there is."""
    touched = touched_robot(write_thumb(tmp_path), ["skin"])
    assert touched is not None
    ends = [run.position[0, -1] for run in exploring(touched.robot, 0, touched).runs[-32:]]
    assert len(np.unique(ends)) == len(ends)
    assert min(ends) < 0.1 * max(ends)


def test_a_robot_that_touches_nothing_else_has_no_spheres(tmp_path: Path) -> None:
    design = exploring(load_robot(write_thumb(tmp_path)))
    assert all(run.pressed is None for run in design.runs)
