"""Rows of effectors of every kind against finite differences, on tetrahedra, beams and reduced robots."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.effectors import ALL_KINDS, BEAM_KINDS, END, SIZE, beams, disturbed, moved, solid

from tauten.model import Robot, RobotFileError, State


def differences(robot: Robot, state: State, step: float, rng: np.random.Generator) -> float:
    """Largest difference of H dq from the change of the goal values, relative to that change."""
    layout, rows, worst = robot.effector_layout, robot.rows(state, contacts=False).effectors, 0.0
    for _ in range(5):
        dq = step * rng.standard_normal(robot.n)
        after, before = (robot.effector_values(moved(robot, state, s * dq)) for s in (1.0, -1.0))
        expected = 0.5 * (
            layout.difference(after, rows.values) - layout.difference(before, rows.values)
        )
        found = rows.dense() @ dq
        for part in layout.parts():
            error = np.linalg.norm(found[part] - expected[part])
            worst = max(worst, float(error / np.linalg.norm(expected[part])))
    return worst


def test_rows_of_tetrahedra_are_derivatives() -> None:
    robot, rng = solid(), np.random.default_rng(1)
    state = disturbed(robot, rng, 1e-3)
    assert differences(robot, state, 1e-6, rng) < 1e-6


def test_rows_of_beams_are_derivatives(tmp_path: Path) -> None:
    robot, rng = beams(tmp_path, BEAM_KINDS), np.random.default_rng(2)
    state = disturbed(robot, rng, 0.05)
    assert differences(robot, state, 1e-5, rng) < 1e-6


def test_values_of_the_rows_are_those_of_the_state() -> None:
    robot = solid()
    state = disturbed(robot, np.random.default_rng(3), 1e-3)
    rows = robot.rows(state, contacts=False).effectors
    np.testing.assert_array_equal(rows.values, robot.effector_values(state))
    np.testing.assert_array_equal(rows.positions, robot.effector(state))
    assert len(rows) == robot.layout.n_e == 3 + 6 + 3 + 1 + 1 + 1
    assert len(rows.values) == robot.effector_layout.n_values == 16


def test_values_at_rest_are_geometry() -> None:
    robot = solid()
    layout, values = robot.effector_layout, robot.effector_values(robot.rest())
    by_name = {name: values[layout.values_of(i)] for i, name in enumerate(layout.names)}
    np.testing.assert_allclose(by_name["tool"], [0.12, 0.0, 0.01, 1.0, 0.0, 0.0, 0.0], atol=1e-14)
    np.testing.assert_allclose(by_name["middle"], [0.1, 0.01, 0.01], atol=1e-14)
    np.testing.assert_allclose(by_name["span"], np.hypot(0.08, 0.02))
    route = np.array([[-0.01, 0.0, 0.01], *ALL_KINDS[4]["points"]])
    np.testing.assert_allclose(
        by_name["sensor"], np.linalg.norm(np.diff(route, axis=0), axis=1).sum()
    )
    np.testing.assert_allclose(by_name["room"], 0.06 * 0.01 * 0.01)


def test_errors_count_in_metres_by_the_size_and_the_volume() -> None:
    """A radian like the size of the robot, a cubic metre V^(-2/3) times at a volume V at rest."""
    robot = solid()
    layout, rest = robot.effector_layout, robot.effector_values(robot.rest())
    units = {name: layout.units[layout.rows_of(i)] for i, name in enumerate(layout.names)}
    np.testing.assert_allclose(units.pop("tool"), [1.0] * 3 + [np.linalg.norm(SIZE)] * 3)
    np.testing.assert_allclose(units.pop("room"), (0.06 * 0.01 * 0.01) ** (-2.0 / 3.0))
    for found in units.values():
        np.testing.assert_array_equal(found, 1.0)
    fuller = rest.copy()
    fuller[-1] += 1e-8  # m³, over 330 mm²
    assert layout.error(fuller, rest) == pytest.approx(1e-8 / 6e-6 ** (2.0 / 3.0))


@pytest.mark.parametrize("of", ["tetrahedra", "beams"])
def test_weight_and_forces_on_effectors_are_the_derivatives_of_their_work(
    tmp_path: Path, of: str
) -> None:
    """A force acts where the effector is; that on a frame on the mean of its region, so it has none here."""
    rng = np.random.default_rng(7)
    robot: Robot = solid() if of == "tetrahedra" else beams(tmp_path, BEAM_KINDS)
    state = disturbed(robot, rng, 1e-3)
    force = rng.standard_normal((len(robot.effector_names), 3))
    force[[kind == "frame" for kind in robot.effector_layout.kinds]] = 0.0
    gravity, none = np.array([3.0, -5.0, 8.0]), np.zeros(3)
    bare = robot.loaded(none, np.zeros(force.size))
    for loaded, pushed in (
        (robot.loaded(none, force.ravel()), force),
        (robot.loaded(gravity, np.zeros(force.size)), None),
    ):
        outer = loaded.forces(state)[0] - bare.forces(state)[0]
        for _ in range(3):
            dq = 1e-5 * rng.standard_normal(robot.n)
            ends = [moved(robot, state, sign * dq) for sign in (0.5, -0.5)]
            lost, before = (loaded.potential(at) - bare.potential(at) for at in ends)
            assert before - lost == pytest.approx(float(outer @ dq), rel=1e-4)
            if pushed is not None:
                after, start = (robot.effector(at) for at in ends)
                work = float(np.vdot(pushed, after - start))
                assert work == pytest.approx(float(outer @ dq), rel=1e-4)


@pytest.mark.parametrize(
    ("effector", "part"),
    [
        ({"kind": "frame"}, "region: needed by an effector of kind 'frame'"),
        ({"kind": "centre"}, "region: needed"),
        ({"kind": "distance", "point": [0.1, 0.0, 0.0]}, "other: needed"),
        ({"kind": "length", "points": [[0.1, 0.0, 0.0]]}, "pull_point or a second point"),
        ({"kind": "volume", "region": END, "point": [0.1, 0.0, 0.0]}, "point: not a field"),
        ({"kind": "volume"}, "give either region or inside"),
        ({"kind": "pose", "point": [0.1, 0.0, 0.0]}, "kind"),
        ({"point": [0.1, 0.0, 0.0], "weight": [1.0, 1.0]}, "2 numbers"),
        ({"point": [0.1, 0.0, 0.0], "weight": 0.0}, "all components are zero"),
        ({"point": [0.1, 0.0, 0.0], "weight": -1.0}, "weight"),
        ({"kind": "centre", "region": "nowhere"}, "region 'nowhere' is not defined"),
    ],
)
def test_what_an_effector_lacks_is_named(effector: dict[str, Any], part: str) -> None:
    with pytest.raises(ValueError, match=part):
        solid([{"name": "one", **effector}])


def test_regions_without_frame_or_volume_are_named() -> None:
    edge = {"lower": [0.09, -1.0, -1.0], "upper": [1.0, 1.0, 0.001]}
    corner = {"lower": [0.09, -1.0, -1.0], "upper": [1.0, 0.001, 0.001]}
    for region in (edge, corner):
        with pytest.raises(RobotFileError, match=r"beam: effectors\.0\.region: .* line"):
            solid([{"name": "one", "kind": "frame", "region": region}])
    top = {"kind": "normal", "direction": [0.0, 0.0, 1.0]}
    for region, message in ((top, "is not closed"), ({"kind": "skin"}, "from outside")):
        with pytest.raises(RobotFileError, match=rf"effectors\.0: .* {message}"):
            solid([{"name": "one", "kind": "volume", "region": region}])
    with pytest.raises(
        RobotFileError, match=r"effectors\.0: the point .* in none of the 1 cavities"
    ):
        solid([{"name": "one", "kind": "volume", "inside": [0.001, 0.001, 0.001]}])
    with pytest.raises(RobotFileError, match=r"effectors\.0\.other: coincides with point"):
        point = [0.1, 0.0, 0.0]
        solid([{"name": "one", "kind": "distance", "point": point, "other": point}])


def test_beams_have_no_volume(tmp_path: Path) -> None:
    with pytest.raises(RobotFileError, match="beams have no cavity"):
        beams(tmp_path, [{"name": "one", "kind": "volume", "region": END}])
