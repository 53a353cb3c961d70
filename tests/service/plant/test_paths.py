"""Start and extent of paths, and checks of path files line by line."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.examples import shipped_robot, shipped_setup

from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import command_range
from tauten.service.plant import PathError, PathSettings, bending_command, make_path, save_path
from tauten.service.plant.paths import SHAPES, Plane

SETTINGS = PathSettings(size=0.01, period=4.0)


@pytest.fixture(scope="module")
def tip(finger: Robot) -> Array:
    """Where the finger's tip is under its weight: (3,) [m]."""
    simulator = Simulator(finger)
    assert simulator.settle_start().converged
    return simulator.effector[0]


@pytest.mark.parametrize("shape", SHAPES)
def test_shapes_start_and_end_where_the_tip_starts(finger: Robot, tip: Array, shape: str) -> None:
    path = make_path(shape, finger, SETTINGS)
    np.testing.assert_allclose(path.at(0.0), tip, atol=1e-12)
    assert path.repeats
    assert path.duration == 4.0
    np.testing.assert_allclose(path.at(4.0 * 3 + 1.3), path.at(1.3), atol=1e-12)


def test_a_circle_is_round_and_lies_in_its_plane(finger: Robot, tip: Array) -> None:
    planes: tuple[Plane, ...] = ("xy", "xz", "yz")
    for plane in planes:
        path = make_path("circle", finger, PathSettings(size=0.01, plane=plane))
        up = np.eye(3)["xyz".index(plane[1])]
        centre = tip + 0.01 * up
        radius = np.linalg.norm(path.values - centre, axis=1)
        np.testing.assert_allclose(radius, 0.01, rtol=1e-12)
        normal = 3 - "xyz".index(plane[0]) - "xyz".index(plane[1])
        assert np.ptp(path.values[:, normal]) == 0.0
        # between the samples the chord is off by less than 1e-5 of the size
        at = np.array([path.at(t) for t in np.linspace(0.0, 10.0, 1001)])
        assert np.abs(np.linalg.norm(at - centre, axis=1) - 0.01).max() < 1e-5 * 0.01


def test_a_line_goes_its_length(finger: Robot) -> None:
    points = make_path("line", finger, SETTINGS).values
    assert np.ptp(points, axis=0) == pytest.approx([0.01, 0.0, 0.0])


def test_a_path_survives_its_csv(finger: Robot, tmp_path: Path) -> None:
    path = make_path("figure-eight", finger, SETTINGS)
    save_path(path, tmp_path / "targets.csv")
    back = make_path(str(tmp_path / "targets.csv"), finger, PathSettings(repeats=True))
    np.testing.assert_array_equal(back.times, path.times)
    np.testing.assert_array_equal(back.values, path.values)


def test_a_csv_without_times_has_the_rate(finger: Robot, tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("y, x, z\n1, 2, 3\n\n4, 5, 6\n")
    path = make_path(str(file), finger, PathSettings(rate=10.0))
    np.testing.assert_array_equal(path.values, [[2.0, 1.0, 3.0], [5.0, 4.0, 6.0]])
    assert path.times.tolist() == [0.0, 0.1]
    np.testing.assert_allclose(path.at(0.05), [3.5, 2.5, 4.5])
    np.testing.assert_array_equal(path.at(9.0), [5.0, 4.0, 6.0])  # the last point is kept


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1: found"),
        ("x,y\n1,2\n", "line 1: found"),
        ("x,y,z,x\n1,2,3,4\n", "line 1: found"),
        ("x,y,z\n", "no points"),
        ("x,y,z\n1,2\n", "line 2: found 2 values, expected 3"),
        ("x,y,z\n1,2,3\n1,two,3\n", "line 3: could not convert string to float: 'two'"),
        ("x,y,z\n1,nan,3\n", "line 2: 1, nan, 3 is not finite"),
        ("t,x,y,z\n0,1,2,3\n1,1,2,3\n1,1,2,3\n", "line 4: t does not grow"),
        ("t,x,y,z\n\n0,1,2,3\n\n1,1,2,3\n\n1,1,2,3\n", "line 7: t does not grow"),
    ],
)
def test_bad_files_are_refused_with_the_line(
    finger: Robot, tmp_path: Path, text: str, message: str
) -> None:
    file = tmp_path / "a.csv"
    file.write_text(text)
    with pytest.raises(PathError, match=message):
        make_path(str(file), finger, SETTINGS)


def test_other_names_are_refused(finger: Robot, tmp_path: Path) -> None:
    with pytest.raises(PathError, match=r"no path 'square': allowed are circle"):
        make_path("square", finger, SETTINGS)
    with pytest.raises(PathError, match=r"cannot be read \(No such file or directory\)"):
        make_path(str(tmp_path / "none.csv"), finger, SETTINGS)


@pytest.mark.long
@pytest.mark.parametrize("name", ["pneumatic_finger", "trunk"])
def test_reach_starts_where_a_controller_does(name: str) -> None:
    """Also where it commands tensions of opposed cables, whose positions are zero at the start."""
    robot = shipped_setup(name).robot
    simulator = Simulator(robot)
    assert simulator.settle_start().converged
    path = make_path("reach", robot, PathSettings())
    np.testing.assert_allclose(path.at(0.0), simulator.effector[0], atol=1e-6)


@pytest.mark.slow
def test_reach_goes_on_where_there_is_no_equilibrium(
    finger: Robot[NodalBody], caplog: pytest.LogCaptureFixture
) -> None:
    """Ten times the pull that the winch has: the path goes as far as the finger does."""
    far = replace(
        finger, limits=replace(finger.limits, position_max=10.0 * finger.limits.position_max)
    )
    path = make_path("reach", far, PathSettings(period=4.0, fraction=1.0))
    assert "which were shortened" in caplog.text
    assert np.isfinite(path.values).all()
    assert np.ptp(path.values, axis=0).max() > 0.05  # m


def test_cables_on_the_other_side_do_not_pull(beam: Robot[NodalBody]) -> None:
    """The load of `tauten compare`: one of two antagonistic cables."""
    command = bending_command(beam)
    assert command.position == pytest.approx([0.02, 0.0])
    assert Simulator(beam).settle(position=command.position).converged


def test_cables_that_may_be_let_out_get_tensions_within_their_range(beam: Robot[NodalBody]) -> None:
    """Antagonists with winches so strong that their largest tension crushes the robot."""
    positions, strong = beam.limits.position_max, np.full(2, 1e5)
    limits = replace(beam.limits, position_min=-positions, effort_max=strong)
    found = command_range(replace(beam, limits=limits))
    assert found.by_force.all()
    assert (found.least == 0.0).all()
    simulator = Simulator(beam)
    for cable in range(2):
        effort = found.command(np.eye(2)[cable]).effort
        assert simulator.settle(effort=effort).converged
        assert simulator.position[cable] == pytest.approx(positions[cable], rel=1e-3)


@pytest.mark.long
def test_cables_that_lengthen_each_other_get_tensions(beam: Robot[NodalBody]) -> None:
    """Wound to random lengths, cables on opposite sides of a trunk crush it."""
    trunk = shipped_robot("trunk")
    wound = replace(trunk.limits, position_min=np.zeros(trunk.n_a))
    assert command_range(replace(trunk, limits=wound)).by_force.all()
    assert not command_range(beam).by_force.any()  # so thick that both cables shorten it


def test_winches_that_do_not_pay_out_are_commanded_by_pull(beam: Robot[NodalBody]) -> None:
    found = command_range(beam)
    command = found.command(np.array([0.5, -1.0]))
    assert np.isnan(command.effort).all()
    assert command.position == pytest.approx([0.01, 0.0])


@pytest.mark.long
def test_reach_takes_as_long_as_the_robot_needs(beam: Robot[NodalBody]) -> None:
    """In 10 s the tip of the manipulator had to go 8 m, and was 0.4 m (RMS) from its targets."""
    limits = beam.limits
    slow = replace(beam, limits=replace(limits, rate=limits.rate / 50.0))
    path = make_path("reach", slow, PathSettings())
    np.testing.assert_allclose(path.values, make_path("reach", beam, PathSettings()).values)
    # the last of three turns, to 0.8 of the largest position along a cosine, at half of the largest rate
    turn = 2.0 * np.pi * 0.8 * float((limits.position_max / (0.5 * slow.limits.rate)).max())
    assert path.duration == pytest.approx(3.0 * turn, rel=0.1)
    assert make_path("reach", slow, PathSettings(period=4.0)).duration == 4.0
