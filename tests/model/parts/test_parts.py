"""A robot of parts does what each of its parts does alone, wherever it stands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.robots.combinations import AXES, BODIES, Option, Settings, robot_with, write_networks

from tauten.controller import Controller
from tauten.model import Robot, Simulator, State
from tauten.model.body import natural_frequencies
from tauten.model.numerics import Array, product
from tauten.model.parts import Assembly, Between, Part, PartsBody, Placement, join_parts

GRAVITY = np.array([0.0, 0.0, -9.81])
TURN = Rotation.from_rotvec([0.3, -1.1, 0.7])
PLACES = (
    Placement(np.eye(3), np.array([0.0, 0.0, 0.0])),
    Placement(TURN.as_matrix(), np.array([0.3, -0.1, 0.2])),
)
NEEDS_PACKAGES = ("transmission", "function")  # by entry points, see tests/extension
Options = list[tuple[str, str]]
OPTIONS: list[Options] = [
    [(axis, name)]
    for axis, options in {"body": BODIES, **AXES}.items()
    for name in options
    if name not in NEEDS_PACKAGES and name != "rigid body"  # nothing holds it: see test_objects
]
REDUCED_BEAMS = [("body", "network of beams"), ("reduction", "state basis")]
REDUCED_DRIVE = [("map", "rotating drive"), ("reduction", "state basis")]


def alone(kind: Options, folder: Path, place: Placement, gravity: Array = GRAVITY) -> Robot:
    """A robot of a kind, under gravity as it is in a place."""
    write_networks(folder)
    robot = robot_with(kind, folder)
    none = np.zeros(3 * len(robot.effector_names))
    return robot.loaded(place.into_part(gravity), none)


def assembly(contacts_of: Robot, gravity: Array = GRAVITY) -> Assembly:
    """Parts that do not touch each other."""
    none = np.zeros(0, dtype=np.int64)
    contacts = contacts_of.contacts
    return Assembly(
        "pair", "base", "", gravity, contacts_of.tolerance,
        contacts.alarm_distance, contacts.distance, Between((none, none), ()),
    )  # fmt: skip


def pair(
    kind: Options, folder: Path, gravity: Array = GRAVITY
) -> tuple[Robot[PartsBody], list[Robot]]:
    """Two robots of a kind in different places, and each by itself."""
    robots = [alone(kind, folder, place, gravity) for place in PLACES]
    parts = [
        Part(name, robot, place)
        for name, robot, place in zip(("a", "b"), robots, PLACES, strict=True)
    ]
    return join_parts(assembly(robots[0], gravity), parts), robots


def same_states(joined: Robot[PartsBody], state: State, alone: list[State]) -> float:
    """Largest difference of a number of the configuration of parts from those of robots by themselves."""
    pairs = zip(joined.body.states(state), alone, strict=True)
    return max(float(np.abs(own.q - one.q).max()) for own, one in pairs)


def drive(robot: Robot, k: int) -> Array:
    """Positions (n_a,) of a motion in step k [m]."""
    limits = robot.limits
    share = 0.2 * np.sin(0.3 * k)
    return np.asarray(
        limits.position_min + (0.2 + share) * (limits.position_max - limits.position_min)
    )


def named(kind: Options) -> str:
    """The options in the name of a test."""
    return ", ".join(name for _, name in kind)


@pytest.mark.long
@pytest.mark.parametrize("kind", [*OPTIONS, REDUCED_BEAMS, REDUCED_DRIVE], ids=named)
def test_steps_rows_and_energy_are_those_of_each_part(kind: Options, tmp_path: Path) -> None:
    """Bodies, maps, rows, elements, laws, contacts and bases of every kind."""
    joined, robots = pair(kind, tmp_path)
    both, each = Simulator(joined), [Simulator(robot) for robot in robots]
    for k in range(4):
        both.step(np.concatenate([drive(robot, k + i) for i, robot in enumerate(robots)]))
        for i, one in enumerate(each):
            one.step(drive(robots[i], k + i))
    size = robots[0].size
    assert same_states(joined, both.state, [one.state for one in each]) < 1e-10 * size
    np.testing.assert_allclose(
        both.effort, np.concatenate([one.effort for one in each]), rtol=1e-7, atol=1e-9
    )
    at = [place.points(one.effector) for place, one in zip(PLACES, each, strict=True)]
    np.testing.assert_allclose(both.effector, np.concatenate(at), atol=1e-12)
    np.testing.assert_allclose(
        joined.energy(both.state),
        sum(robot.energy(one.state) for robot, one in zip(robots, each, strict=True)),
        rtol=1e-9, atol=1e-14,
    )  # fmt: skip


SOME = [
    [],
    [("map", "rotating drive")],
    [("body", "network of beams")],
    [("reduction", "state basis")],
    REDUCED_BEAMS,
]


@pytest.mark.parametrize("kind", [*SOME, [("contact", "obstacle")]], ids=named)
def test_equilibria_and_vibration_are_those_of_each_part(kind: Options, tmp_path: Path) -> None:
    joined, robots = pair(kind, tmp_path)
    both, each = Simulator(joined), [Simulator(robot) for robot in robots]
    assert both.settle(effort=np.zeros(joined.n_a)).converged
    assert all(one.settle(effort=np.zeros(one.robot.n_a)).converged for one in each)
    close = 1e-7 * robots[0].size
    assert same_states(joined, both.state, [one.state for one in each]) < close
    found = natural_frequencies(joined.body, both.state, 4)
    own = [natural_frequencies(one.robot.body, one.state, 4) for one in each]
    np.testing.assert_allclose(found, np.sort(np.concatenate(own))[: len(found)], rtol=1e-4)


@pytest.mark.long
@pytest.mark.parametrize("kind", [*SOME, [("law", "viscosity")]], ids=named)
def test_converged_steps_are_those_of_each_part(kind: Options, tmp_path: Path) -> None:
    """Parts divide a period together: without gravity cables become taut at the same time in both."""
    joined, robots = pair(kind, tmp_path, np.zeros(3))
    both, each = Simulator(joined), [Simulator(robot) for robot in robots]
    for k in range(3):
        both.move(np.concatenate([0.1 * drive(robot, k) for robot in robots]), steps=16)
        for one, robot in zip(each, robots, strict=True):
            one.move(0.1 * drive(robot, k), steps=16)
    assert same_states(joined, both.state, [one.state for one in each]) < 1e-7 * robots[0].size


@pytest.mark.parametrize("more", [[], [("reduction", "state basis")]], ids=named)
def test_a_static_part_has_no_inertia_beside_a_dynamic_one(more: Options, tmp_path: Path) -> None:
    """What it weighs changes nothing without gravity: centrifugal forces moved it by 0.7 mm."""
    ends = []
    for density in (1e3, 3e4):
        options = [("map", "rigid region"), *more]
        static, dynamic = (
            robot_with(options, tmp_path, with_scheme(scheme, density))
            for scheme in ("quasi-static", "implicit-euler")
        )
        parts = [
            Part(name, robot, place)
            for name, robot, place in zip("ab", (static, dynamic), PLACES, strict=True)
        ]
        joined = join_parts(assembly(static, np.zeros(3)), parts)
        simulator = Simulator(joined)
        for k in range(2):
            moved = drive(static, 3 * k)
            simulator.move(np.concatenate([moved, np.zeros(dynamic.n_a)]), steps=4)
        ends.append(joined.body.states(simulator.state)[0].q)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)


@pytest.mark.long
@pytest.mark.parametrize(("option", "periods"), [(("map", "hinge"), 3), (("row", "drum"), 20)])
def test_a_static_part_comes_to_rest_beside_a_dynamic_one(
    option: tuple[str, str], periods: int, tmp_path: Path
) -> None:
    """Under its weight and 0.4 rad at once: steps of Newton's method of any length led to and fro."""
    kinds = ([option], "quasi-static"), ([], "implicit-euler")
    static, dynamic = (robot_with(kind, tmp_path, with_scheme(one, 1e3)) for kind, one in kinds)
    static = static.loaded(GRAVITY, np.zeros(3))
    parts = [Part(*each) for each in zip("ab", (static, dynamic), PLACES, strict=True)]
    both, alone = Simulator(join_parts(assembly(static), parts)), Simulator(static)
    pulled = np.array([0.006 if option[0] == "map" else -0.4])  # m, rad
    for _ in range(periods):
        both.move(np.concatenate([pulled, np.zeros(dynamic.n_a)]))
    assert alone.settle(position=pulled).converged
    assert np.linalg.norm(alone.effector[0] - static.effector(static.rest())[0]) > 0.01
    np.testing.assert_allclose(both.effector[0], alone.effector[0], atol=1e-7)
    np.testing.assert_allclose(both.effort[:1], alone.effort, rtol=1e-5)


def with_scheme(scheme: str, density: float) -> Option:
    """The option that a robot takes steps of a scheme and has a density [kg/m³]."""

    def change(settings: Settings) -> None:
        settings["integration"] = {"scheme": scheme}
        settings["material"]["density"] = density

    return change


def test_a_frame_turns_with_its_part_from_no_rotation_at_rest(tmp_path: Path) -> None:
    joined, robots = pair([("row", "frame")], tmp_path)
    layout, rest = joined.effector_layout, joined.effector_values(joined.rest())
    at = next(i for i, kind in enumerate(layout.kinds) if kind == "frame" and i >= len(layout) // 2)
    values = layout.values_of(at)
    np.testing.assert_allclose(np.abs(rest[values][3:]), [1.0, 0.0, 0.0, 0.0], atol=1e-9)
    state = joined.rest()
    rng = np.random.default_rng(1)
    dq = 1e-4 * robots[0].size * rng.normal(size=joined.n)
    moved = State(state.q + dq, state.v, state.memory)
    change = layout.difference(joined.effector_values(moved), rest)
    H = joined.rows(state).effectors.dense()
    np.testing.assert_allclose(H @ dq, change, atol=2e-3 * np.abs(change).max())
    # the rotation of the part alone, seen in the robot's frame: Q R Qᵀ
    own = robots[1].effector_values(joined.body.states(moved)[1])[
        robots[1].effector_layout.values_of(at - len(layout) // 2)
    ]
    x, y, z, w = TURN.as_quat()
    q = (w, x, y, z)
    seen = product(product(q, tuple(own[3:])), (w, -x, -y, -z))
    np.testing.assert_allclose(joined.effector_values(moved)[values][3:], seen, atol=1e-9)


def test_forces_on_effectors_and_gravity_turn_into_the_part(tmp_path: Path) -> None:
    joined, robots = pair([], tmp_path)
    force, gravity = np.array([0.01, -0.02, 0.03]), np.array([1.0, 2.0, -9.0])
    none = np.zeros(3)
    both = Simulator(joined.loaded(gravity, np.concatenate([none, force])))
    place = PLACES[1]
    one = Simulator(robots[1].loaded(place.into_part(gravity), place.into_part(force)))
    assert both.settle(effort=np.zeros(2)).converged
    assert one.settle(effort=np.zeros(1)).converged
    np.testing.assert_allclose(both.effector[1], place.points(one.effector)[0], atol=1e-9)


@pytest.mark.parametrize("kind", [[], [("reduction", "state basis")]], ids=named)
def test_a_controller_moves_parts_as_it_moves_each(kind: Options, tmp_path: Path) -> None:
    """Two equal parts with equal targets: the decision of each does not see the other."""
    robots = [alone(kind, tmp_path, PLACES[0]) for _ in range(2)]
    parts = [Part(name, robot, PLACES[0]) for name, robot in zip("ab", robots, strict=True)]
    joined = join_parts(assembly(robots[0]), parts)
    both, one = Controller(joined), Controller(robots[0])
    target = robots[0].effector(robots[0].rest()) + np.array([0.0, 0.0, -0.01])
    for _ in range(10):
        left, own = both.step(np.concatenate([target, target])), one.step(target)
    assert left.status == own.status
    np.testing.assert_allclose(left.position, np.tile(own.position, 2), rtol=1e-6, atol=1e-12)


def test_copies_are_independent_and_have_one_step_length(tmp_path: Path) -> None:
    joined, _ = pair([], tmp_path)
    slower = joined.with_integration(joined.integration.__class__(rate=10.0, static=True))
    assert slower.h == 0.1
    assert all(part.integration.static and part.h == 0.1 for part in slower.body.part_robots)
    fork = joined.fork()
    rest = joined.rest()
    first, second = joined.linearise(rest), fork.linearise(State(rest.q, rest.v + 1.0, rest.memory))
    again = joined.linearise(rest)
    np.testing.assert_array_equal(first.v_free, again.v_free)
    assert not np.allclose(first.v_free, second.v_free)
