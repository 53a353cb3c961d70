"""How far a change of the configuration moves a robot: the way of its nodes, whichever way the axes lie."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist
from scipy.spatial.transform import Rotation
from support.robots.short_arm import short_arm
from support.robots.small_bodies import rigid_box, small_body
from support.state_bases import basis_of, turned_space

from tauten.model import State
from tauten.model.numerics import Array, diameter, longest
from tauten.reduction.state import reduced_robot, reducible

DIRECTIONS = np.array([[1.0, 0.0, 0.0], [1.0, -1.0, 0.0], [-1.0, 1.0, 1.0], [2.0, 3.0, -6.0]])
WAYS: Array = 2e-3 * DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)  # m


@pytest.mark.parametrize("shape", ["box", "cloud", "ball"])
def test_the_largest_distance_is_that_of_all_pairs_in_any_axes(shape: str) -> None:
    """The diagonal of the bounding box of a box is so, but not when it is turned."""
    rng = np.random.default_rng(2)
    points = rng.standard_normal((60, 3)) * [3.0, 2.0, 1.0]
    if shape == "box":
        points = np.array(list(itertools.product((0.0, 3.0), (0.0, 4.0), (0.0, 12.0))))
    elif shape == "ball":
        points /= np.linalg.norm(points, axis=1)[:, None]
    for turn in Rotation.random(5, random_state=2):
        assert diameter(turn.apply(points) + 7.0) == pytest.approx(pdist(points).max(), rel=1e-12)
    assert shape != "box" or diameter(points) == 13.0
    assert diameter(points[:0]) == diameter(points[:1]) == 0.0


def test_the_largest_distance_of_many_points_on_a_sphere_is_found() -> None:
    """As of a fine surface of a ball, where nearly all points are ends of a long distance."""
    points = np.random.default_rng(3).standard_normal((4000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    opposite = cKDTree(points).query(-points)[0].min()
    assert diameter(points) == pytest.approx(np.sqrt(4.0 - opposite**2), rel=1e-12)


def test_the_longest_of_vectors_is_so_in_any_axes() -> None:
    rng = np.random.default_rng(0)
    vectors = rng.normal(size=(20, 3))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    largest = max(np.linalg.norm(one) for one in vectors)
    for given in (vectors, vectors @ turn.T, vectors.ravel()):
        assert longest(given) == pytest.approx(largest, rel=1e-12)
    assert longest(1e200 * vectors) == pytest.approx(1e200 * largest, rel=1e-12)
    assert longest(np.zeros(0)) == longest(np.zeros(6)) == 0.0
    assert np.isnan(longest(np.array([1.0, np.nan, 0.0])))
    assert longest(np.array([1.0, -np.inf, 0.0])) == np.inf


@pytest.mark.parametrize("way", WAYS, ids=str)
def test_what_moves_along_a_line_moves_by_its_length(way: Array, tmp_path: Path) -> None:
    """Nodes of tetrahedra, a rigid body and beams: the numbers of steps must not depend on the axes."""
    free, rigid, arm = small_body("linear"), rigid_box(), short_arm(tmp_path)
    none = np.zeros(3)
    for robot, dq in (
        (free, np.tile(way, robot_nodes(free.n, 3))),
        (rigid, np.concatenate([way, none])),
        (arm, np.tile(np.concatenate([way, none]), robot_nodes(arm.n, 6))),
    ):
        assert robot.displacement(robot.rest(), dq) == pytest.approx(2e-3, rel=1e-9)


def robot_nodes(n: int, each: int) -> int:
    """Nodes of so many unknowns each."""
    assert n % each == 0
    return n // each


def test_in_modes_it_is_the_way_of_the_effector() -> None:
    body = small_body("linear")
    every = np.arange(reducible(body).n_elements)
    robot = reduced_robot(body, basis_of(body, turned_space(body), every, np.ones(len(every))))
    rest, dq = robot.rest(), 1e-4 * np.random.default_rng(2).normal(size=robot.n)
    moved = robot.effector(State(rest.q + dq, rest.v)) - robot.effector(rest)
    assert robot.displacement(rest, dq) == pytest.approx(np.linalg.norm(moved), rel=1e-9)
