"""What is drawn of a robot: cables as long as they are, forces along normals, on all kinds of robots."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.examples import shipped_robot
from support.robots.small_bodies import END, MIDDLE, SLIDE, TURN, constrained, moved

from tauten.model import EmptySpace, Robot, Simulator, State, skin_of
from tauten.model.actuators import enclosed_volume
from tauten.reduction.state import StateBasis, reduced_robot


@pytest.fixture(scope="module")
def settled(finger: Robot) -> Simulator:
    """The coarse finger, pulled until its notches touch."""
    simulator = Simulator(finger)
    assert simulator.settle(position=[0.03]).converged
    return simulator


@pytest.fixture(scope="module")
def bent(settled: Simulator) -> tuple[Robot, State]:
    """The finger, and its state pulled until its notches touch."""
    return settled.robot, settled.state


def test_drawn_cables_are_shorter_by_what_is_pulled(bent: tuple[Robot, State]) -> None:
    check_lengths(*bent)


@pytest.mark.long
def test_drawn_cables_of_a_reduced_robot() -> None:
    reduced = reduced_robot(shipped_robot("finger"), StateBasis.load("finger"))
    simulator = Simulator(reduced, contact="none")
    assert simulator.settle(position=[0.01]).converged
    check_lengths(reduced, simulator.state)


def test_drawn_cables_of_a_robot_of_beams() -> None:
    robot = shipped_robot("manipulator")
    simulator = Simulator(robot, contact="none")
    position = np.zeros(robot.n_a)
    position[:2] = 0.004, -0.002
    for _ in range(5):
        simulator.step(position=position)
    check_lengths(robot, simulator.state)


def check_lengths(robot: Robot, state: State) -> None:
    """Lengths of the drawn cables differ from those at rest by the pulled lengths."""
    delta = robot.rows(state, contacts=False).actuators.delta
    assert np.abs(delta).max() > 1e-3
    assert lengths(robot, robot.rest()) - lengths(robot, state) == pytest.approx(delta, abs=1e-6)


def lengths(robot: Robot, state: State) -> np.ndarray:
    """Lengths of the drawn cables (n_a,) [m]."""
    ends = robot.actuator_segments(state)
    pieces = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    return np.bincount(robot.actuator_set.segment_owners, pieces, minlength=robot.n_a)


def test_drawn_forces_open_the_contacts(bent: tuple[Robot, State]) -> None:
    """Moved along its arrow, a candidate has a larger gap, by as much: in the rows of the step."""
    robot, state = bent
    rows = robot.rows(state).contacts
    normals = rows.found.normal
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)
    expected = robot.candidates(state)[rows.slots]
    np.testing.assert_allclose(rows.found.point, expected, atol=1e-15)
    # all bodies moved alike, no gap changes; H of a candidate's own nodes sums to its normal
    H = rows.rows.dense().reshape(len(rows), -1, 3)  # (m, nodes, 3)
    along = np.einsum("mni,mi->mn", H, normals)
    across = H - along[:, :, None] * normals[:, None]
    assert np.abs(across).max() < 1e-12
    assert np.maximum(along, 0.0).sum(axis=1).max() == pytest.approx(1.0)


def test_the_skin_is_the_surface_and_forces_in_it_push(settled: Simulator) -> None:
    robot, simulator = settled.robot, settled
    skin = skin_of(robot)
    geometry = skin.geometry(robot, simulator.state, simulator.contacts)
    assert np.array_equal(skin.used[skin.triangles], robot.triangles)
    assert geometry.vertices == pytest.approx(robot.points(simulator.state)[skin.used], abs=1e-7)
    contacts = geometry.contacts
    total = np.linalg.norm(contacts.forces, axis=1).sum()
    assert total == pytest.approx(simulator.lam_c.sum(), rel=5e-3)  # smaller ones are not drawn
    assert len(contacts.points) > 10


def test_forces_have_the_directions_of_the_step_that_gave_them(settled: Simulator) -> None:
    """Not those of the state to which they lead: the finger is let go, and its notches open."""
    simulator = Simulator(settled.robot)
    simulator.start_from(settled.state, settled.forces)
    before = simulator.state
    simulator.step(position=[0.028])
    lam, drawn = simulator.lam_c, simulator.contact_forces
    pushing = lam > 0.0
    assert pushing.sum() > 3
    assert not drawn[~pushing].any()
    forces, space = simulator.forces, EmptySpace(simulator.robot.n_c)
    expected, after = (
        forces.on(settled.robot.rows(state).contacts.found, space).at_candidates()
        for state in (before, simulator.state)
    )
    np.testing.assert_allclose(drawn, expected, atol=1e-12)
    assert np.abs(after - drawn).max() > 1e-3 * lam.max()


def test_drawn_drives_and_forces_move_by_their_position() -> None:
    """Along their directions by δ; the axis of a servo stays; motors of couplings own their members."""
    push = {
        "name": "push", "point": [0.1, 0.01, 0.01], "direction": [0.0, 0.0, 2.0],
        "max_force": 5.0, "max_travel": 0.02, "max_rate": 0.1,
    }  # fmt: skip
    robot = constrained(
        drives=[{**TURN, "region": MIDDLE}, {**SLIDE, "region": END}],
        forces=[push],
        couplings=[
            {
                "name": "motor", "members": ["push"], "gains": [2.0],
                "max_position": 1.0, "max_effort": 10.0, "max_rate": 1.0,
            }
        ],
    )  # fmt: skip
    rest = robot.rest()
    state = moved(robot, rest, 2e-3 * np.random.default_rng(3).standard_normal(robot.n))
    owner = {name: i for i, name in enumerate(robot.actuators.names)}
    delta = robot.rows(state, contacts=False).actuators.delta
    before, after = robot.actuator_segments(rest), robot.actuator_segments(state)
    assert sorted(set(robot.actuator_set.segment_owners.tolist())) == list(range(robot.n_a))
    for name, gain in (("motor", 2.0), ("slider", 1.0)):
        (place,) = np.flatnonzero(robot.actuator_set.segment_owners == owner[name])
        along = after[place, 1] - after[place, 0]
        assert along == pytest.approx([0.0, 0.0, 1.0])
        shift = (after[place, 0] - before[place, 0]) @ along
        assert gain * shift == pytest.approx(delta[owner[name]], rel=1e-9)
    (servo,) = np.flatnonzero(robot.actuator_set.segment_owners == owner["servo"])
    assert after[servo] == pytest.approx(before[servo])
    assert before[servo, 1] - before[servo, 0] == pytest.approx([0.0, 1.0, 0.0])
    assert (robot.body.chamber_owners == -1).all()


def test_the_drawn_chamber_has_the_volume_of_the_chamber() -> None:
    robot = shipped_robot("pneumatic_finger")
    rng = np.random.default_rng(4)
    rest = robot.rest()
    state = State(rest.q + 1e-4 * rng.standard_normal(robot.n), rest.v)
    delta = robot.rows(state, contacts=False).actuators.delta
    for chamber in range(robot.n_a):
        triangles = robot.triangles[robot.body.chamber_owners == chamber]
        assert len(triangles) > 100
        volumes = [-enclosed_volume(robot.points(at), triangles) for at in (rest, state)]
        assert volumes[0] > 0.0
        assert volumes[1] - volumes[0] == pytest.approx(delta[chamber], rel=1e-6)
