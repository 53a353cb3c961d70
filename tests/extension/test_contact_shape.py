"""The contact shape of docs/extend.md: a ring that another package has, around every kind of body."""

from __future__ import annotations

import re
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from support.robots.combinations import (
    Option,
    add,
    every,
    is_network,
    robot_with,
    write_networks,
)
from support.robots.my_package import tables
from support.robots.small_bodies import small_body
from support.state_bases import basis_of, turned_space

from tauten.controller import Controller, Status
from tauten.model import Robot, RobotFileError, Simulator, State
from tauten.model.numerics import Array
from tauten.reduction.state import reduced_robot, reducible

PAGE = next(found for found in tables() if "obstacles" in found)
HOOP: dict[str, Any] = PAGE["obstacles"][0]
CENTRE, RADIUS, WIRE = np.array([0.1, 0.01, 0.01]), 0.02, 0.005
BODIES = [
    [], [("element", "quadratic")], [("map", "rotating drive")], [("map", "glue")],
    [("body", "rigid body"), ("map", "pin")], [("map", "pin of a beam")],
    [("body", "network of beams")], [("body", "network with a loop")],
    [("reduction", "state basis")], [("map", "rotating drive"), ("reduction", "state basis")],
    [("body", "network of beams"), ("reduction", "state basis")],
]  # fmt: skip


def to_ring(points: Array) -> Array:
    """Distances (m,) to the ring, by another way than that of the page: to its centre line, in steps."""
    angles = np.linspace(0.0, 2.0 * np.pi, 20_001)
    line = CENTRE + RADIUS * np.stack([0.0 * angles, np.cos(angles), np.sin(angles)], axis=1)
    return np.array([np.linalg.norm(line - point, axis=1).min() - WIRE for point in points])


def around(**table: Any) -> Option:
    """The contact of the robot's upper surface, or of its skin, with the ring."""

    def contact(settings: dict[str, Any]) -> None:
        box = {"lower": [-1.0, -1.0, -1.0], "upper": [1.0, 1.0, 1.0]}
        if is_network(settings):
            settings["regions"] = [{"name": "top", "kind": "group", "group": "top"}]
        else:
            settings["surfaces"] = [{"name": "top", "box": box, "normal": [0.0, 0.0, 1.0]}]
        settings["contacts"] = [{"candidates": "top", "against": "hoop", "points": 40}]
        settings["contact"] = {"alarm_distance": 0.5}

    return every(contact, add("obstacles", **{**HOOP, **table}))


def test_the_distance_of_the_ring_is_that_to_its_wire(package: ModuleType) -> None:
    points = CENTRE + 0.02 * np.random.default_rng(0).normal(size=(50, 3))
    gap, normal = package.Ring(CENTRE, np.array([1.0, 0.0, 0.0]), RADIUS, 2.0 * WIRE).closest(
        points
    )
    np.testing.assert_allclose(gap, to_ring(points), atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0)


@pytest.mark.parametrize("options", BODIES, ids=lambda found: ", ".join(name for _, name in found))
def test_gaps_are_distances_and_rows_their_derivatives(
    package: ModuleType, tmp_path: Path, options: list[tuple[str, str]]
) -> None:
    write_networks(tmp_path)
    robot = robot_with([*options, ("row", "cable")], tmp_path, around())
    rng, rest = np.random.default_rng(1), robot.rest()

    def moved(state: State, dq: Array) -> State:
        return robot.advance(state, dq, 1.0)

    def direction(state: State) -> Array:
        dq = rng.normal(size=robot.n)
        found: Array = dq * 2e-3 / robot.displacement(state, dq)
        return found

    state = moved(rest, direction(rest))
    contacts = robot.rows(state).contacts
    assert len(contacts) == robot.n_c == 40
    np.testing.assert_allclose(contacts.found.point, robot.candidates(state), atol=1e-12)
    np.testing.assert_allclose(contacts.rows.delta, to_ring(contacts.found.point), atol=1e-8)
    for _ in range(3):
        d, step = direction(state), 1e-3
        up, down = (robot.rows(moved(state, by * d)).contacts.rows.delta for by in (step, -step))
        np.testing.assert_allclose(
            contacts.rows.dense() @ d, (up - down) / (2.0 * step), rtol=1e-3, atol=1e-7
        )


def ringed(**changes: Any) -> Robot:
    """A beam whose tip has a ring around it, and a cable that bends it."""
    return small_body("linear", obstacles=[{**HOOP, **changes}], contacts=PAGE["contacts"])


def test_the_ring_stops_a_beam_that_is_pulled_aside(package: ModuleType) -> None:
    """Its corners have 20 − 5 − 14.1 mm to the wire: it moves so far, and no candidate is in the wire."""
    free, held = Simulator(small_body("linear"), "none"), Simulator(ringed(), "full")
    for simulator in (free, held):
        assert simulator.settle(position=[2e-3]).converged
    rest = free.robot.effector(free.robot.rest())[0]
    moved = [np.linalg.norm((one.effector[0] - rest)[1:]) for one in (free, held)]
    assert moved[0] > 3.5e-3
    assert moved[1] < 1.5e-3
    rows = held.robot.rows(held.state).contacts
    assert rows.rows.delta.min() > -held.robot.tolerance
    assert held.lam_c.sum() > 0.1  # N
    touching = held.lam_c > 0.0
    np.testing.assert_allclose(to_ring(held.robot.candidates(held.state)[touching]), 0.0, atol=5e-5)


@pytest.mark.long
@pytest.mark.parametrize("reduced", [False, True])
def test_decisions_heed_the_ring(package: ModuleType, reduced: bool) -> None:
    """Towards a target beyond it the tip comes to rest at the wire, in modes of all space too."""
    robot = ringed()
    if reduced:
        every, Phi = np.arange(reducible(robot).n_elements), turned_space(robot)
        robot = reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))
    controller = Controller(robot, "full")
    goal = controller.effector_values + np.array([0.0, 0.0, -1.5e-3])
    for _ in range(80):
        decided = controller.step(goal)
        assert decided.status.usable
    gaps = robot.rows(controller.state).contacts.rows.delta
    assert gaps.min() == pytest.approx(0.0, abs=2.0 * robot.tolerance)
    moved = robot.effector(robot.rest())[0] - controller.effector[0]
    assert 0.8e-3 < moved[2] < 1.3e-3, "the wire is 0.86 mm away, and the corners are soft"


def test_a_distance_that_is_no_number_is_not_passed_over(
    package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The robot holds until distances are known again: it went through the wire, with status OK."""
    controller, known = Controller(ringed(), "full"), package.Ring.closest
    goal = controller.effector_values + np.array([0.0, 0.0, -1.5e-3])
    assert controller.step(goal).status.usable
    monkeypatch.setattr(package.Ring, "closest", lambda self, y: (y[:, 0] * np.nan, y * np.nan))
    found = [controller.step(goal).status for _ in range(5)]
    assert found[-1] is Status.NOT_FINITE
    monkeypatch.setattr(package.Ring, "closest", known)
    assert [controller.step(goal).status for _ in range(5)][-1].usable


def test_what_is_no_shape_is_refused(package: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    parameters = HOOP["parameters"]
    refused = {
        "hoop.shape: 'cone' is unknown, found are plane, sphere, capsule, cylinder, box, mesh, height-field, "
        "ring": {"shape": "cone"},
        "hoop.parameters: thickness 1 m must be positive": {"parameters": {**parameters, "thickness": 1.0}},
        "hoop.parameters: 'axis' is missing,": {"parameters": {"centre": [0.0, 0.0, 0.0]}},
    }  # fmt: skip
    for sentence, changes in refused.items():
        with pytest.raises(RobotFileError, match=re.escape(sentence)):
            ringed(**changes)
    monkeypatch.setattr(package.Ring, "closest", lambda self, points: (points[:, 0], 2.0 * points))
    with pytest.raises(RobotFileError, match=r"contacts\.0\.against: the shape gives the normal"):
        ringed()
    monkeypatch.setattr(package.Ring, "closest", lambda self, points: (points, points))
    with pytest.raises(
        RobotFileError, match=r"gives distances of the shape \(\d+, 3\), expected is"
    ):
        ringed()
