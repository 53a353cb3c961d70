"""Paths of effectors of every kind, as shapes and as CSV files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.effectors import solid

from tauten.model import Robot
from tauten.model.tetra import NodalBody
from tauten.service.describing import describe
from tauten.service.plant import PathError, PathSettings, make_path, save_path
from tauten.service.plant.streaming import _warn_of_distance
from tauten.service.plant.waypoints import COLUMNS, TargetPath
from tauten.service.setup import load_setup

FRAME, SPAN, ROOM = 1, 3, 5  # of the robot below


@pytest.fixture(scope="module")
def robot() -> Robot[NodalBody]:
    return solid()


def test_a_frame_moves_along_a_shape_and_keeps_its_rotation(robot: Robot[NodalBody]) -> None:
    path = make_path("circle", robot, PathSettings(effector=FRAME, size=0.01))
    assert path.kind == "frame"
    np.testing.assert_allclose(path.values[:, 3:] - [1.0, 0.0, 0.0, 0.0], 0.0, atol=1e-13)
    assert np.ptp(path.values[:, 0]) == pytest.approx(0.02, rel=1e-3)


@pytest.mark.parametrize("effector", [SPAN, ROOM])
def test_a_scalar_swings_by_a_tenth_of_what_it_is(robot: Robot[NodalBody], effector: int) -> None:
    layout, rest = robot.effector_layout, robot.effector_values(robot.rest())
    path = make_path("line", robot, PathSettings(effector=effector))
    start = rest[layout.values_of(effector)][0]
    assert path.values.shape[1] == 1
    assert path.values[0, 0] == pytest.approx(start)
    assert path.values.max() == pytest.approx(1.1 * start)


@pytest.mark.parametrize("effector", range(6))
def test_a_path_of_any_kind_survives_its_csv(
    robot: Robot[NodalBody], effector: int, tmp_path: Path
) -> None:
    path = make_path("figure-eight", robot, PathSettings(effector=effector))
    save_path(path, tmp_path / "a.csv")
    header = (tmp_path / "a.csv").read_text().splitlines()[0]
    assert header == ",".join(["t", *COLUMNS[path.kind]])
    back = make_path(str(tmp_path / "a.csv"), robot, PathSettings(effector=effector))
    np.testing.assert_allclose(back.values, path.values, rtol=1e-15)
    np.testing.assert_array_equal(back.times, path.times)


def test_a_path_is_replaced_whole_or_not_at_all(robot: Robot[NodalBody], tmp_path: Path) -> None:
    """The file was emptied first: what read it meanwhile got half a path."""
    file = tmp_path / "a.csv"
    save_path(make_path("circle", robot, PathSettings()), file)
    before = file.read_text()
    with file.open() as opened:
        save_path(make_path("line", robot, PathSettings()), file)
        assert opened.read() == before
    assert file.read_text() != before


def test_a_csv_of_a_spreadsheet_may_begin_with_its_mark(
    robot: Robot[NodalBody], tmp_path: Path
) -> None:
    file = tmp_path / "a.csv"
    file.write_text("x,y,z\n0.01,0.02,0.03\n", encoding="utf-8-sig")
    values = make_path(str(file), robot, PathSettings()).values
    assert values.tolist() == [[0.01, 0.02, 0.03]]


@pytest.mark.parametrize("unit", [1.0, 1e3])
def test_targets_in_millimetres_are_warned_of(
    beam_file: Path, caplog: pytest.LogCaptureFixture, unit: float
) -> None:
    """The node refuses them one by one, of which its sender hears nothing."""
    described = describe(load_setup(beam_file))
    values = unit * np.array([described.effectors[0].rest])
    _warn_of_distance(described, TargetPath(np.zeros(1), values, False), 0)
    assert ("the node refuses those beyond" in caplog.text) == (unit > 1.0)


def test_rotations_are_interpolated_the_short_way_and_have_length_one(
    robot: Robot[NodalBody], tmp_path: Path
) -> None:
    file = tmp_path / "turn.csv"
    turns = Rotation.from_rotvec([[0.0, 0.0, 0.0], [0.0, 0.0, 0.4]]).as_quat()
    turns[1] *= -1.0  # the same rotation
    lines = [",".join(map(repr, [0.1, 0.0, 0.0, *turn.tolist()])) for turn in turns]
    file.write_text("x,y,z,qx,qy,qz,qw\n" + "\n".join(lines) + "\n")
    path = make_path(str(file), robot, PathSettings(effector=FRAME, rate=1.0))
    middle = path.at(0.5)
    assert np.linalg.norm(middle[3:]) == pytest.approx(1.0, abs=1e-15)
    found = Rotation.from_quat(middle[[4, 5, 6, 3]])
    assert found.approx_equal(Rotation.from_rotvec([0.0, 0.0, 0.2]), atol=1e-12)


@pytest.mark.parametrize(
    ("effector", "text", "message"),
    [
        (FRAME, "x,y,z\n1,2,3\n", "expected column names x, y, z, qw, qx, qy, qz and optionally t"),
        (FRAME, "x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,2\n", "line 2: the quaternion has length 2 "),
        (SPAN, "x,y,z\n1,2,3\n", "expected column names distance and optionally t"),
        (ROOM, "volume\nnan\n", "line 2: nan is not finite"),
    ],
)
def test_a_file_of_another_kind_is_named(
    robot: Robot[NodalBody], effector: int, text: str, message: str, tmp_path: Path
) -> None:
    file = tmp_path / "wrong.csv"
    file.write_text(text)
    with pytest.raises(PathError, match=message):
        make_path(str(file), robot, PathSettings(effector=effector))


@pytest.mark.parametrize("effector", [FRAME, SPAN, ROOM])
def test_reach_finds_targets_of_any_kind(robot: Robot[NodalBody], effector: int) -> None:
    path = make_path("reach", robot, PathSettings(effector=effector, period=4.0))
    layout, rest = robot.effector_layout, robot.effector_values(robot.rest())
    assert path.kind == layout.kinds[effector]
    np.testing.assert_allclose(path.at(0.0), rest[layout.values_of(effector)], atol=1e-4)
    assert np.ptp(path.values, axis=0).max() > 1e-9
    if path.kind == "frame":
        np.testing.assert_allclose(np.linalg.norm(path.values[:, 3:], axis=1), 1.0)
