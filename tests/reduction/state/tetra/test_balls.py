"""Balls around candidates that modes move: what they leave out is out of reach of the obstacle."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tauten.model.contact import SHAPES, ContactPair, ContactSet, Obstacle, pose_at
from tauten.model.numerics import Array
from tauten.model.parts import PartsPoints, Placement
from tauten.model.parts.motion import PartsMotion, PointsOfPart
from tauten.reduction.state.tetra.body import ModeMotion, ModePoints

ALARM = 0.03
M, R = 600, 5
NONE = np.zeros((0, 3), dtype=np.int64)


def rod(rng: np.random.Generator) -> ModePoints:
    """Points in a rod of one metre along z, and modes that bend, twist and stretch it."""
    x = rng.uniform([-0.1, -0.1, 0.0], [0.1, 0.1, 1.0], size=(M, 3))
    X, Y, Z = x.T
    zero = np.zeros(M)
    bend, wave = (Z**2, zero, -2.0 * X * Z), (zero, np.sin(7.0 * Z), -7.0 * Y * np.cos(7.0 * Z))
    twist, stretch, noise = (-Y * Z, X * Z, zero), (zero, zero, Z), 0.1 * rng.normal(size=(3, M))
    map_ = np.stack([np.stack(mode) for mode in (bend, wave, twist, stretch, noise)])  # (R, 3, M)
    return ModePoints(x.ravel(), np.ascontiguousarray(map_.transpose(2, 1, 0).reshape(3 * M, R)))


def contacts_on(shape: str, parameters: dict[str, object], rng: np.random.Generator) -> ContactSet:
    """Candidates anywhere between three points near each other, and an obstacle that has moved."""
    obstacle = Obstacle(
        "it", SHAPES[shape](**parameters), pose_at([0.02, -0.01, 0.05], [1.0, 0.1, 0.2, 0.0])
    )
    first = np.arange(M)[:, None]
    pair = ContactPair(
        "it", (first + np.arange(3)) % M, rng.dirichlet([1, 1, 1], M), NONE, obstacle=obstacle
    )
    return ContactSet([pair], M, ALARM)


@pytest.mark.parametrize("placed_part", [False, True])
@pytest.mark.parametrize(
    ("shape", "parameters"),
    [
        ("plane", {"point": [0.3, 0.0, 0.0], "normal": [-1.0, 0.0, 0.3]}),
        ("sphere", {"centre": [0.3, 0.1, 0.7], "radius": 0.2}),
        ("box", {"lower": [0.1, -0.5, 0.5], "upper": [0.5, 0.5, 0.9]}),
        ("cylinder", {"start": [0.2, -1.0, 0.6], "end": [0.2, 1.0, 0.6], "radius": 0.1}),
    ],
)
def test_the_same_candidates_are_in_range(
    shape: str, parameters: dict[str, object], placed_part: bool
) -> None:
    """Those of all points, at small and large deflections; where few are in range few points are placed."""
    rng = np.random.default_rng(5)
    own, contacts = rod(rng), contacts_on(shape, parameters, rng)
    points: ModePoints | PartsPoints = own
    if placed_part:
        turned = Placement(
            Rotation.from_euler("xyz", [0.3, -0.2, 1.0]).as_matrix(), np.full(3, 0.05)
        )
        points = PartsPoints((PointsOfPart(0, own, turned),))
    balled, in_range, places = contacts.over(points), list[int](), list[int]()
    for size in rng.choice([0.0, 1e-3, 0.05, 0.3, 1.0, 10.0], 60):
        motion: ModeMotion | PartsMotion = ModeMotion(size * rng.normal(size=R), None, np.zeros(0))
        if placed_part:
            motion = PartsMotion((motion,), (slice(0, R),))
        found, placed = balled.found(motion, points)
        expected = contacts.detect(motion.placed(points).y)
        np.testing.assert_array_equal(found.slots, expected.slots)
        np.testing.assert_allclose(found.gap, expected.gap, atol=1e-13)
        np.testing.assert_array_equal(found.normal.shape, expected.normal.shape)
        in_range.append(len(found))
        places.append(int(np.isfinite(placed.y[:, 0]).sum()))
    assert max(in_range) > 20
    assert min(places) < M / 2


def test_a_moving_obstacle_is_met_by_the_same_candidates() -> None:
    """In a step in which candidates keep their side of an obstacle all of them are compared."""
    rng = np.random.default_rng(6)
    points = rod(rng)
    contacts = contacts_on("box", {"lower": [0.1, -1.0, -1.0], "upper": [0.11, 1.0, 2.0]}, rng)
    before = contacts.poses.with_pose("it", pose_at())
    moved = contacts.placed(
        before.with_pose("it", pose_at([-0.5, 0.0, 0.0], None, [-50.0, 0.0, 0.0]))
    )
    motion = ModeMotion(np.zeros(R), None, np.zeros(0))
    x: Array = motion.placed(points).y
    found = moved.over(points).stepping(x, [x], before).found(motion, points)[0]
    expected = moved.stepping(x, [x], before).detect(x)
    assert len(expected) > len(moved.detect(x)) == 0  # it has passed them
    np.testing.assert_array_equal(found.slots, expected.slots)
    np.testing.assert_allclose(found.gap, expected.gap, atol=1e-13)


def test_a_state_that_has_diverged_touches_nothing() -> None:
    """No candidate is in range where no position is known."""
    rng = np.random.default_rng(7)
    points = rod(rng)
    contacts = contacts_on("sphere", {"centre": [0.0, 0.0, 0.5], "radius": 0.2}, rng).over(points)
    assert len(contacts.found(ModeMotion(np.zeros(R), None, np.zeros(0)), points)[0]) > 0
    assert len(contacts.found(ModeMotion(np.full(R, np.nan), None, np.zeros(0)), points)[0]) == 0
