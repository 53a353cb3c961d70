"""Waypoints are played at a steady speed, and saved as `tauten stream` reads them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.messages import effector

from tauten.model import Robot
from tauten.service.frames import WaypointList
from tauten.service.plant import PathError, PathSettings, make_path

POINTS = np.array([[0.1, 0.01, 0.012], [0.1, 0.01, 0.016], [0.1, 0.013, 0.016]])
SPEED = 0.002  # m/s


TIP = effector("tip", "point", 0.1, 0.01, 0.01)


def listed() -> WaypointList:
    """Three waypoints."""
    waypoints = WaypointList(TIP, 0.1)
    for point in POINTS:
        assert waypoints.add(point)
    return waypoints


def test_the_target_moves_at_the_speed() -> None:
    start = np.array([0.1, 0.01, 0.01])
    path = listed().path(start, SPEED)
    assert path.duration == pytest.approx((0.002 + 0.004 + 0.003) / SPEED)
    times = np.linspace(0.0, path.duration, 301)
    places = np.array([path.at(time) for time in times])
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(times)
    assert np.median(speeds) == pytest.approx(SPEED)
    assert places[0] == pytest.approx(start)
    assert places[-1] == pytest.approx(POINTS[-1])


def test_a_saved_file_is_a_path_for_stream(tmp_path: Path, beam: Robot) -> None:
    file = tmp_path / "waypoints.csv"
    file.write_text(listed().csv(SPEED))
    path = make_path(str(file), beam, PathSettings())
    assert [path.at(time) for time in (0.0, 2.0, 3.5)] == [pytest.approx(one) for one in POINTS]


def test_there_is_a_largest_number() -> None:
    waypoints = WaypointList(TIP, 0.1)
    while waypoints.add(POINTS[0]):
        assert len(waypoints) <= 1000
    count = len(waypoints)
    assert not waypoints.add(POINTS[1])
    assert len(waypoints.points) == count
    waypoints.clear()
    assert len(waypoints.points) == 0


def test_a_frame_turns_the_short_way_and_a_volume_changes_steadily(tmp_path: Path) -> None:
    turn = np.array([np.cos(0.5), 0.0, 0.0, np.sin(0.5)])  # by 1 rad about z
    start = np.array([0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    hand = WaypointList(effector("hand", "frame", *start), 0.1)
    hand.add(np.concatenate([start[:3], -turn]))
    path = hand.path(start, 0.01)
    assert path.duration == pytest.approx(10.0)  # 1 rad counts like the size, 0.1 m
    assert path.at(10.0)[3:] == pytest.approx(turn)
    assert hand.csv(0.01).splitlines()[0] == "t,x,y,z,qw,qx,qy,qz"
    bag = WaypointList(effector("bag", "volume", 1e-6), 0.1)
    bag.add(np.array([1.5e-6]))
    assert bag.path(np.array([1e-6]), 0.01).duration == pytest.approx(0.5)
    assert len(bag.points) == 0


def test_they_are_a_list_to_edit() -> None:
    waypoints = listed()
    assert waypoints.names()[0] == "1: 100.0, 10.0, 12.0 mm"
    assert waypoints.move(2, -1) == 1
    assert waypoints.move(0, -1) == 0
    assert waypoints.points == pytest.approx(POINTS[[0, 2, 1]])
    waypoints.remove(0)
    waypoints.remove(7)
    assert waypoints.points == pytest.approx(POINTS[[2, 1]])
    straight = waypoints.straight(np.array([0.1, 0.01, 0.01]), 1, SPEED)
    assert straight.duration == pytest.approx(0.006 / SPEED)
    assert straight.at(straight.duration) == pytest.approx(POINTS[1])


def test_a_file_takes_their_place_or_nothing_changes() -> None:
    waypoints = listed()
    waypoints.load("z,x,y\n0.02,0.1,0.01\n0.03,0.1,0.01\n", "two.csv")
    assert waypoints.points == pytest.approx(np.array([[0.1, 0.01, 0.02], [0.1, 0.01, 0.03]]))
    for text in ("", "x,y\n1,2", "x,y,z\n1,2,nan", "x,y,z\n" + "1,2,3\n" * 201):
        with pytest.raises(PathError, match=r"two.csv: "):
            waypoints.load(text, "two.csv")
    assert len(waypoints) == 2
