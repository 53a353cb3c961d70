"""The controller on a beam with two cables: limits, bad targets, equilibria, resets."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import beam_robot, box_mesh

from tauten.controller import Controller
from tauten.controller.qpcc import Status
from tauten.model import EmptySpace, Robot, RobotFileError, Simulator, State, no_forces
from tauten.model.numerics import Array

SIZE = (0.1, 0.02, 0.02)
DOWN = np.array([0.0, 0.0, -0.01])  # m, within reach
NANOMETRE = 1e-9  # pulls are sums of terms of some centimetres, limits hold to 1e-8 of that


def tendon(name: str, height: float) -> dict[str, object]:
    return {
        "name": name,
        "points": [[0.01, 0.01, height], [0.1, 0.01, height]],
        "max_tension": 20.0,
        "max_pull": 0.015,
        "max_rate": 0.05,
    }


@pytest.fixture(scope="module")
def beam() -> Robot:
    """A cable below and one above the middle, which can bend it both ways and shorten it."""
    return beam_robot(
        box_mesh(SIZE, (8, 2, 2)),
        SIZE,
        cables=[tendon("lower", 0.002), tendon("upper", 0.018)],
        integration={"scheme": "implicit-euler", "rayleigh_stiffness": 0.02},
        controller={"rate": 50.0},
    )


def follow(controller: Controller, target: Array, steps: int) -> None:
    for _ in range(steps):
        controller.step(target)


def test_a_still_target_at_rest_needs_no_force(beam: Robot) -> None:
    controller = Controller(beam)
    tip = controller.effector[0]
    actuation = controller.step(tip)
    assert actuation.status is Status.OK
    np.testing.assert_allclose(actuation.effort, 0.0, atol=1e-9)
    np.testing.assert_allclose(actuation.position, 0.0, atol=1e-12)
    np.testing.assert_allclose(actuation.effector[0], tip, atol=1e-12)


def test_targets_above_and_below_pull_the_cable_on_their_side(beam: Robot) -> None:
    for sign, pulling in ((-1.0, 0), (1.0, 1)):
        controller = Controller(beam)
        target = controller.effector[0] - sign * DOWN
        follow(controller, target, 60)
        assert controller.effort[pulling] > 0.5
        assert controller.position[pulling] > controller.position[1 - pulling]
        # the end of a bent beam is nearer: the nearest it comes to a point right above or below
        assert np.linalg.norm(controller.effector[0] - target) < 0.4 * np.linalg.norm(DOWN)


def test_limits_are_kept_whatever_the_target(beam: Robot) -> None:
    rng = np.random.default_rng(1)
    controller, limits = Controller(beam), beam.limits
    tip = controller.effector[0]
    position, reached = controller.position, np.zeros(3, dtype=bool)
    for step in range(120):
        if step % 20 == 0:
            target = tip + rng.normal(size=3) * 10.0 ** rng.uniform(-3.0, 3.0)
        actuation = controller.step(target)
        moved = np.abs(actuation.position - position) / (limits.rate * beam.h)
        assert np.all(actuation.effort >= limits.effort_min)
        assert np.all(actuation.effort <= limits.effort_max)
        assert np.all(actuation.position >= limits.position_min - NANOMETRE)
        assert np.all(actuation.position <= limits.position_max + NANOMETRE)
        assert np.all(moved <= 1.0 + 1e-6)
        assert actuation.status is not Status.NOT_FINITE
        position = actuation.position
        reached |= [
            bool(np.any(moved >= 1.0 - 1e-6)),
            bool(np.any(actuation.position >= limits.position_max - 1e-9)),
            bool(np.any(actuation.effort <= 1e-9)),
        ]
    assert reached.all()  # the limits were there to be kept


@pytest.mark.long
def test_a_target_out_of_reach_is_approached_and_then_held(beam: Robot) -> None:
    controller = Controller(beam)
    tip = controller.effector[0]
    target = tip + 50.0 * DOWN
    distances = []
    for _ in range(100):
        actuation = controller.step(target)
        assert actuation.status is Status.OK
        distances.append(np.linalg.norm(controller.effector[0] - target))
    assert distances[-1] < distances[0] - 0.01
    np.testing.assert_allclose(distances[-20:], distances[-1], atol=1e-6)


@pytest.mark.parametrize(
    ("target", "found"),
    [
        ([0.0, 0.0], "shape (2,)"),
        ([], "shape (0,)"),
        ([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], "shape (2, 3)"),
        (0.1, "shape ()"),
        (None, "shape ()"),
        ("here", "'here'"),
        ([0.0, "there", 0.0], "[0.0, 'there', 0.0]"),
        ([[1.0], [2.0, 3.0]], "[[1.0], [2.0, 3.0]]"),
        ([10**400, 0.0, 0.0], "[1000"),
        (np.array([0.0, 1j, 0.0]), "array([0.+0.j, 0.+1.j, 0.+0.j])"),
    ],
    ids=str,
)
def test_a_target_of_another_shape_is_refused_without_effect(
    beam: Robot, target: object, found: str
) -> None:
    controller, undisturbed = Controller(beam), Controller(beam)
    goal = controller.effector[0] + DOWN
    follow(controller, goal, 3)
    follow(undisturbed, goal, 3)
    for attempt in (controller.step, controller.decide, controller.rehearse):
        with pytest.raises(
            ValueError, match=r"expected shape \(3,\), the position of tip \[m\]"
        ) as said:
            attempt(target)  # type: ignore[arg-type]
        assert f"target: found {found}" in str(said.value)
    after, expected = controller.step(goal), undisturbed.step(goal)
    assert after.status is Status.OK
    np.testing.assert_array_equal(after.effort, expected.effort)


@pytest.mark.parametrize("given", ["nope", 3])
def test_a_qp_library_that_is_none_is_refused_when_a_controller_is_made(
    beam: Robot, given: object
) -> None:
    """It was named in the first step."""
    with pytest.raises(
        (RobotFileError, TypeError), match=r"nope|expected a name or a function, found int"
    ):
        Controller(beam, qp=given)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "target", [[np.nan, 0.0, 0.0], [0.0, np.inf, 0.0], [None, 0.0, 0.0]], ids=str
)
def test_an_invalid_target_holds_with_a_status(beam: Robot, target: object) -> None:
    controller = Controller(beam)
    goal = controller.effector[0] + DOWN
    follow(controller, goal, 10)
    position = controller.position.copy()
    for _ in range(3):
        actuation = controller.step(target)  # type: ignore[arg-type]
        assert actuation.status is Status.NOT_FINITE
        np.testing.assert_array_equal(actuation.position, position)
        assert np.isfinite(actuation.effort).all()
    assert controller.step(goal).status is Status.OK


def test_the_equilibrium_reached_is_the_simulators(beam: Robot) -> None:
    simulator = Simulator(beam, contact="none")
    assert simulator.settle(position=[0.006, 0.0]).converged
    controller = Controller(beam)
    follow(controller, simulator.effector[0], 200)
    # the weight of the elastic energy keeps it from getting there altogether
    error = np.linalg.norm(controller.effector - simulator.effector)
    assert error < 1e-3 * np.linalg.norm(simulator.effector - beam.effector(beam.rest()))
    settled = Simulator(beam, contact="none")
    settled.settle(position=controller.position)
    np.testing.assert_allclose(controller.effector, settled.effector, atol=1e-7)
    np.testing.assert_allclose(controller.effort, settled.effort, rtol=1e-4, atol=1e-4)


def test_predictions_come_true(beam: Robot) -> None:
    """Within the error of one linearisation in motion, a share of the way; exactly where the robot rests."""
    controller = Controller(beam)
    target, errors, moves = controller.effector[0] + DOWN, [], []
    for _ in range(20):
        before = controller.effector
        actuation = controller.decide(target)
        np.testing.assert_array_equal(controller.position, actuation.position)
        controller.advance()
        errors.append(np.linalg.norm(controller.effector - actuation.effector))
        moves.append(np.linalg.norm(controller.effector - before))
        actual = controller.robot.rows(controller.state, contacts=False).actuators.delta
        np.testing.assert_allclose(actual, actuation.position, atol=5e-5)
    assert max(errors) < 0.12 * max(moves)
    assert errors[-1] < 1e-9


@pytest.mark.long
def test_holding_keeps_the_winches_and_finds_the_equilibrium(beam: Robot) -> None:
    controller = Controller(beam)
    follow(controller, controller.effector[0] + DOWN, 15)
    position = controller.position.copy()
    for _ in range(120):
        actuation = controller.hold()
        controller.advance()
        assert actuation.status is Status.OK
        np.testing.assert_array_equal(actuation.position, position)
        assert np.all(actuation.effort >= 0.0)
    settled = Simulator(beam, contact="none")
    settled.settle(position=position)
    np.testing.assert_allclose(controller.effector, settled.effector, atol=1e-6)


def test_deciding_moves_nothing_and_the_last_decision_counts(beam: Robot) -> None:
    controller, other = Controller(beam), Controller(beam)
    tip = controller.effector[0]
    controller.prepare()
    controller.prepare()
    controller.decide(tip - DOWN)
    np.testing.assert_array_equal(controller.effector[0], tip)
    controller.reset()
    controller.decide(tip + DOWN)
    controller.advance()
    controller.advance()  # nothing more to do
    other.step(tip + DOWN)
    np.testing.assert_array_equal(controller.effector, other.effector)


def test_a_rehearsal_leaves_nothing_behind(beam: Robot) -> None:
    """Whatever was rehearsed in between, before or after a step is prepared or decided."""
    controller, other = Controller(beam), Controller(beam)
    target = controller.effector[0] + DOWN
    for lift in np.linspace(-0.01, 0.01, 8):
        controller.rehearse(target[None] + lift)
        controller.decide(target + 0.1 * lift)
        controller.rehearse(target[None] - lift)
        controller.advance()
        controller.rehearse(target[None])
        controller.prepare()
        controller.rehearse(np.full((1, 3), 1e3))
        other.step(target + 0.1 * lift)
        np.testing.assert_array_equal(controller.position, other.position)
        np.testing.assert_array_equal(controller.effector, other.effector)


def test_a_reset_restores_the_start(beam: Robot) -> None:
    controller = Controller(beam)
    target = controller.effector[0] + DOWN
    first = [controller.step(target).effort for _ in range(10)]
    follow(controller, target + 0.02, 5)
    controller.reset()
    assert controller.status is Status.OK
    np.testing.assert_array_equal(controller.position, 0.0)
    np.testing.assert_array_equal(controller.effector, beam.effector(beam.rest()))
    second = [controller.step(target).effort for _ in range(10)]
    np.testing.assert_array_equal(first, second)


def test_controllers_and_simulators_of_one_robot_do_not_meet(beam: Robot) -> None:
    alone, target = Controller(beam), beam.effector(beam.rest())[0] + DOWN
    expected = [alone.step(target).position for _ in range(10)]
    controller, other = Controller(beam), Controller(beam)
    simulator = Simulator(beam, contact="none")
    positions = []
    for _ in range(10):
        controller.prepare()
        other.step(target - 2.0 * DOWN)
        simulator.step(position=[0.0, 0.01])
        positions.append(controller.decide(target).position)
        controller.advance()
    np.testing.assert_array_equal(positions, expected)


def test_a_model_that_has_blown_up_stands_still(beam: Robot) -> None:
    controller = Controller(beam)
    target = controller.effector[0] + DOWN
    follow(controller, target, 5)
    position = controller.position.copy()
    broken = State(np.full_like(controller.state.q, np.nan), controller.state.v)
    controller.start_from(broken, controller.forces, position)
    for _ in range(2):
        actuation = controller.step(target)
        assert actuation.status is Status.NOT_FINITE
        np.testing.assert_array_equal(actuation.position, position)
    controller.reset()
    assert controller.step(target).status is Status.OK


def test_a_start_of_another_robot_is_refused(beam: Robot) -> None:
    """It failed in the next step, or held for ever."""
    controller, n_a = Controller(beam), beam.n_a
    state, forces = controller.state, controller.forces
    other = State(state.q[:-3], state.v[:-3])
    with pytest.raises(ValueError, match=r"state: found \d+ degrees of freedom, expected"):
        controller.start_from(other, forces, np.zeros(n_a))
    with pytest.raises(ValueError, match="forces: found"):
        controller.start_from(state, no_forces(n_a + 1, 0), np.zeros(n_a))
    for position in (np.zeros(n_a + 1), np.full(n_a, np.nan)):
        with pytest.raises(ValueError, match="position: found"):
            controller.start_from(state, forces, position)
    assert controller.step(controller.effector).status.usable


def test_contact_of_another_robot_is_refused(beam: Robot) -> None:
    with pytest.raises(ValueError, match="the contact basis has 7 slots, the robot 0 candidates"):
        Controller(beam, EmptySpace(7))
    with pytest.raises(ValueError, match='contact is \'some\', allowed are "none", "full"'):
        Controller(beam, "some")  # type: ignore[arg-type]
