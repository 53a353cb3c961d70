from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.robots.small_bodies import MIDDLE, TURN, constrained, small_body

from tauten.model import Robot
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import (
    Design,
    DesignError,
    Ranges,
    command_range,
    exploring,
    from_csv,
    latin_hypercube,
    latin_hypercube_levels,
    plackett_burman,
    plackett_burman_levels,
    ramp,
)


def test_ramp_is_the_papers(finger: Robot) -> None:
    design = ramp(finger)
    (run,) = design.runs
    assert len(run) == design.size == 500
    np.testing.assert_allclose(run.position[0], 5e-5 * np.arange(1, 501))
    np.testing.assert_array_equal(run.gravity[:, 0], finger.gravity)
    assert not run.effector_force.any()
    with pytest.raises(
        DesignError, match=r"step is 0.05 m: allowed are 0 to 0.025 m, .*tendon goes$"
    ):
        ramp(finger, step=0.05)


def test_the_step_of_a_ramp_is_in_the_unit_of_the_actuator_that_it_is_too_long_for() -> None:
    """Of a drive it was "0 to 0.5 m", and nothing was said of a step that is that of a cable, too."""
    drive = {
        "name": "servo", "region": {"lower": [0.1, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]},
        "axis": [0.0, 1.0, 0.0], "through": [0.1, 0.01, 0.01],
        "max_angle": 1e-3, "max_torque": 1.0, "max_rate": 1.0,
    }  # fmt: skip
    said = r"allowed are 0 to 0.001 rad, above 0, as far as servo goes; it is the step of all, whose units"
    with pytest.raises(DesignError, match=said):
        ramp(small_body("linear", drives=[drive]), step=2e-3)


def test_exploring_tilts_and_loads_the_robot_on_all_sides(thumb: Robot[NodalBody]) -> None:
    design = exploring(thumb)
    own, *loaded = design.runs
    np.testing.assert_array_equal(own.gravity, np.tile(thumb.gravity[:, None], len(own)))
    assert not own.effector_force.any()
    down = np.array([0.0, 0.0, -1.0])
    weight = 9.81 * thumb.body.moving_mass
    sides = []
    for run in loaded:
        gravity, force = run.gravity[:, 0], run.effector_force[:, 0]
        assert np.linalg.norm(gravity) == pytest.approx(9.81)
        assert np.degrees(np.arccos(gravity @ down / 9.81)) == pytest.approx(20.0)
        assert np.linalg.norm(force) == pytest.approx(0.2 * weight)
        assert run.position[0, 0] == 0.0
        assert (
            run.position[0, -1] == thumb.limits.position_max[0]
        )  # one actuator: through its range each time
        sides.append(
            np.concatenate(
                [gravity[:2] / (9.81 * np.sin(np.radians(20.0))), force / (0.2 * weight)]
            )
        )
    assert len(loaded) == 40
    # towards each side of each axis a tilt and a payload lean by half of their size at least
    for sign in (1.0, -1.0):
        assert (sign * np.array(sides)).max(axis=0).min() > 0.5


@pytest.mark.parametrize(
    ("factors", "runs"),
    [(1, 4), (3, 4), (4, 8), (7, 8), (8, 12), (11, 12), (12, 20), (19, 20), (20, 24), (33, 44)],
)
def test_plackett_burman_is_balanced_and_orthogonal(factors: int, runs: int) -> None:
    levels = plackett_burman_levels(factors)
    assert levels.shape == (runs, factors)
    signs = 2.0 * levels - 1.0
    np.testing.assert_array_equal(signs.sum(axis=0), 0.0)
    np.testing.assert_array_equal(signs.T @ signs, runs * np.eye(factors))


def test_plackett_burman_of_twelve_runs_is_the_published_one() -> None:
    """Row + + − + + + − − − + − of Plackett and Burman 1946, up to a cyclic shift and a mirror."""
    published = np.array([1, 1, 0, 1, 1, 1, 0, 0, 0, 1, 0])
    row = plackett_burman_levels(11)[0]
    shifts = [np.roll(mirrored, i) for i in range(11) for mirrored in (published, published[::-1])]
    assert any(np.array_equal(row, shift) for shift in shifts)


@pytest.mark.long
@settings(max_examples=6)  # the most even of many cubes is searched
@given(runs=st.integers(1, 12), factors=st.integers(1, 8), seed=st.integers(0, 99))
def test_latin_hypercube_has_one_run_in_every_class(runs: int, factors: int, seed: int) -> None:
    levels = latin_hypercube_levels(runs, factors, seed)
    classes = np.sort(np.floor(levels * runs), axis=0)
    np.testing.assert_array_equal(classes, np.tile(np.arange(runs)[:, None], factors))
    np.testing.assert_array_equal(levels, latin_hypercube_levels(runs, factors, seed))


def test_levels_become_pulls_gravity_and_forces(finger: Robot) -> None:
    ranges = Ranges(position=(0.25, 0.75), tilt=0.5, force=0.3)
    design = plackett_burman(finger, ranges, steps=10)
    assert len(design.runs) == 8  # one cable, two tilts, three force components
    final = [run.position[0, -1] for run in design.runs]
    np.testing.assert_allclose(sorted(set(np.round(final, 12))), [0.00625, 0.01875])
    g = finger.gravity
    for run in design.runs:
        np.testing.assert_allclose(np.linalg.norm(run.gravity, axis=0), np.linalg.norm(g))
        angle = np.arccos(run.gravity[:, 0] @ g / (g @ g))
        assert angle == pytest.approx(0.5 * np.sqrt(2.0))
        np.testing.assert_allclose(np.abs(run.effector_force), 0.3)
    directions = {tuple(np.round(run.gravity[:, 0], 9)) for run in design.runs}
    assert len(directions) == 4


def test_ranges_of_zero_are_no_factors(finger: Robot) -> None:
    design = plackett_burman(finger, Ranges(tilt=0.0, force=0.0), steps=3)
    assert len(design.runs) == 4
    for run in design.runs:
        np.testing.assert_allclose(run.gravity[:, 0], finger.gravity)
        assert not run.effector_force.any()


@pytest.mark.long
def test_latin_hypercube_is_in_range_and_repeats_with_its_seed(finger: Robot) -> None:
    ranges = Ranges(position=(0.2, 1.0), tilt=1.0, force=0.5)
    designs = [latin_hypercube(finger, ranges, runs=9, seed=seed, steps=4) for seed in (0, 0, 1)]
    assert designs[0].digest() == designs[1].digest() != designs[2].digest()
    for run in designs[0].runs:
        assert 0.2 * 0.025 <= run.position[0, -1] <= 0.025
        assert np.abs(run.effector_force).max() <= 0.5
    with pytest.raises(DesignError, match="of 0 runs"):
        latin_hypercube(finger, ranges, runs=0)


@pytest.mark.parametrize(
    "ranges", [{"position": (0.9, 0.1)}, {"position": (0.0, 1.1)}, {"tilt": -1.0}, {"force": -0.1}]
)
def test_ranges_that_make_no_sense(ranges: dict[str, float]) -> None:
    with pytest.raises(DesignError, match="pull must be two shares"):
        Ranges(**ranges)  # type: ignore[arg-type]


def csv_design(robot: Robot, folder: Path, text: str) -> Design:
    path = folder / "runs.csv"
    path.write_text(text)
    return from_csv(robot, path)


def test_csv(finger: Robot, tmp_path: Path) -> None:
    design = csv_design(
        finger,
        tmp_path,
        "run,pull_tendon,gravity_x,force_tip_z\na,0.01,1.5,0\na,0.02,1.5,0.2\nb,0.025,0,0\n",
    )
    first, second = design.runs
    np.testing.assert_array_equal(first.position, [[0.01, 0.02]])
    np.testing.assert_array_equal(first.gravity, [[1.5, 1.5], [0.0, 0.0], [-9.81, -9.81]])
    np.testing.assert_array_equal(first.effector_force[2], [0.0, 0.2])
    np.testing.assert_array_equal(second.position, [[0.025]])
    assert design.description == "runs.csv: 2 runs"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("run\n1\n", r"columns missing: pull_tendon"),
        ("run,pull_tendon,speed\n1,0,0\n", r"unknown: speed"),
        ("run,pull_tendon\n", r"has no rows"),
        ("run,pull_tendon\n1,0.01\n1,fast\n", r"line 3: pull_tendon is 'fast'"),
        ("run,pull_tendon\n1,nan\n", r"line 2: pull_tendon is 'nan'"),
        ("run,pull_tendon\n1\n", r"line 2: pull_tendon is ''"),
        ("run,pull_tendon\n1,0.01,3\n", r"line 2: .*more fields"),
        ("run,pull_tendon\n1,0.05\n", r"line 2: pull_tendon is 0.05 m, allowed are 0.0 to 0.025 m"),
    ],
)
def test_csv_errors_name_the_place(finger: Robot, tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(DesignError, match=message):
        csv_design(finger, tmp_path, text)


def test_csv_that_is_not_there(finger: Robot, tmp_path: Path) -> None:
    with pytest.raises(
        DesignError, match=r"none\.csv: cannot be read \(No such file or directory\)"
    ):
        from_csv(finger, tmp_path / "none.csv")


def test_designs_go_to_the_far_side_of_actuators_that_move_to_one_side_only() -> None:
    """A drive that turns from 0 to −0.4: its largest position is 0."""
    robot = constrained(drives=[{**TURN, "region": MIDDLE, "min_angle": -0.4, "max_angle": 0.0}])
    (servo,) = (i for i, name in enumerate(robot.actuators.names) if name == "servo")
    ranges = Ranges(position=(0.5, 1.0))
    for design in (
        ramp(robot, 1e-2),
        plackett_burman(robot, ranges, 2),
        latin_hypercube(robot, ranges, 2, seed=1, steps=3),
    ):
        ends = np.array([run.position[servo, -1] for run in design.runs])
        assert (ends >= -0.4).all()
        assert ends.min() < -0.2 + 1e-12
        assert ends.max() <= 0.0


def test_every_second_run_of_exploring_ends_at_a_corner_of_the_ranges() -> None:
    """Decisions go there; bases of random commands alone claimed a quarter of the error there."""
    robot = constrained(drives=[{**TURN, "region": MIDDLE}])
    found, corners = command_range(robot), 0
    assert (found.least < 0.0).any() and (found.least == 0.0).any()  # a drive and a cable
    for i, run in enumerate(run for run in exploring(robot).runs if not run.effector_force.any()):
        assert run.effort is not None
        end = np.where(found.by_force, run.effort[:, -1], run.position[:, -1])
        ends = np.isclose(end, found.least) | np.isclose(end, found.most)
        assert ends.all() == (i % 2 == 1)
        assert end.any()
        corners += ends.all()
    assert corners >= 8
