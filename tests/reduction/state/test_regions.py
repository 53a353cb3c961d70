"""State bases of robots with rigid regions, pins and hinges: against the full robots."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.robots.joined import joined, push
from support.robots.small_bodies import (
    END,
    FIRST,
    GLUE,
    HINGE,
    LAST,
    MESH,
    MIDDLE,
    RUBBER,
    SECOND,
    SLIDE,
    TURN,
    constrained,
    moved,
)
from support.state_bases import basis_of, projected

from tauten.model import Robot, Simulator, State
from tauten.model.constraints import ConstrainedBody
from tauten.model.materials import NO_TANGENT
from tauten.model.numerics import Array
from tauten.reduction.state import reduced_robot, reducible
from tauten.reduction.state.modes import pod, with_own, without_own
from tauten.reduction.state.tetra.own_motion import OwnMotion

BOX = ((0.02, 0.02, 0.02), (2, 2, 2))
SOFT = ((0.06, 0.02, 0.02), (6, 2, 2))
FORCES = np.random.default_rng(4).uniform(-1.0, 1.0, size=(24, 3)) * [0.02, 0.05, 0.05]


def chain() -> Robot[ConstrainedBody]:
    """A soft box that is held, glued to it a rigid box, on that two more, each on a hinge."""
    first, second, third = ({"kind": "all", "body": name} for name in ("first", "second", "third"))
    root = {"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}
    face = {"body": "soft", "lower": [0.06, 0.0, 0.0], "upper": [0.06, 0.02, 0.02]}
    return joined(
        [
            {"name": "soft", "fixed": [root]},
            {"name": "first", "rigid": True, "position": [0.06, 0.0, 0.0]},
            {"name": "second", "rigid": True, "position": [0.08, 0.0, 0.0]},
            {"name": "third", "rigid": True, "position": [0.10, 0.0, 0.0]},
        ],
        {"soft": SOFT, "first": BOX, "second": BOX, "third": BOX},
        gravity=[9.81, 0.0, 0.0],
        attachments=[
            {"kind": "glue", "region": face, "to": first},
            {
                "kind": "hinge", "region": second, "to": first, "through": [0.08, 0.01, 0.01],
                "axis": [0.0, 1.0, 0.0], "tilt_stiffness": 0.5,
            },
            {
                "kind": "hinge", "region": third, "to": second, "through": [0.10, 0.01, 0.01],
                "axis": [0.0, 0.0, 1.0], "tilt_stiffness": 0.5,
            },
        ],
        forces=[
            push(name, [0.12, 0.01, 0.01], direction)
            for name, direction in (
                ("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0]),
            )
        ],
        effectors=[{"name": "end", "point": [0.12, 0.01, 0.01]}],
    )  # fmt: skip


def frames_of_each_kind() -> Robot[ConstrainedBody]:
    """Glue that follows a rigid plate, a servo, a slider and a hinge on the frame."""
    return constrained(
        [MESH, MESH], bodies=[FIRST, SECOND], mesh=None, fixed=[], material=RUBBER,
        attachments=[GLUE, HINGE],
        rigid=[{"name": "plate", "region": {**END, "body": "first"}}],
        drives=[{**TURN, "region": MIDDLE}, {**SLIDE, "region": LAST}],
    )  # fmt: skip


@pytest.fixture(scope="module", params=[chain, frames_of_each_kind])
def robot(request: pytest.FixtureRequest) -> Robot[ConstrainedBody]:
    found = request.param()
    assert isinstance(found.body, ConstrainedBody)
    return found


@pytest.fixture(scope="module")
def state(robot: Robot[ConstrainedBody]) -> State:
    """Frames turned by a tenth and more, nodes moved by millimetres."""
    rng = np.random.default_rng(1)
    scale = np.full(robot.n, 1e-3)
    first = 3 * len(robot.body.coordinates.free)
    scale[first + robot.body.frames.rotations[:, None] + np.arange(3)] = 0.3
    scale[first + robot.body.frames.drives] = 0.2
    there = moved(robot, robot.rest(), scale * rng.standard_normal(robot.n))
    return State(there.q, rng.standard_normal(robot.n))


def test_a_configuration_comes_back_from_its_deviations(
    robot: Robot[ConstrainedBody], state: State
) -> None:
    chart = reducible(robot).chart
    back = chart.configuration(chart.deviations(state.q[:, None])[:, 0])
    np.testing.assert_allclose(
        robot.body.nodes(State(back, state.v)), robot.body.nodes(state), atol=1e-12
    )
    rates = chart.rates(state.v[:, None])[:, 0]
    np.testing.assert_allclose(chart.velocity(rates), state.v, atol=1e-9)


def test_rates_are_the_derivative_of_the_deviations(
    robot: Robot[ConstrainedBody], state: State
) -> None:
    chart, step = reducible(robot).chart, 1e-6
    ahead, behind = (
        chart.deviations(moved(robot, state, sign * step * state.v).q[:, None])[:, 0]
        for sign in (1.0, -1.0)
    )
    found = (ahead - behind) / (2.0 * step)
    first = len(found) - 3 * chart.turned  # rotation vectors change as the turn between them
    turns = [Rotation.from_rotvec(one[first:].reshape(-1, 3)) for one in (ahead, behind)]
    found[first:] = (turns[0] * turns[1].inv()).as_rotvec().ravel() / (2.0 * step)
    rates = chart.rates(state.v[:, None])[:, 0]
    np.testing.assert_allclose(rates, found, atol=1e-7 * np.abs(found).max())


@pytest.fixture(scope="module")
def equilibria() -> tuple[Robot[ConstrainedBody], Array]:
    """The chain, and its configurations (n_q, s) under many forces."""
    robot = chain()
    simulator, found = Simulator(robot, "none"), []
    for force in FORCES:
        assert simulator.settle(effort=force).converged
        found.append(simulator.state.q)
    return robot, np.array(found).T


@pytest.mark.long
def test_hinges_in_modes_rest_where_the_full_robot_does(
    equilibria: tuple[Robot[ConstrainedBody], Array],
) -> None:
    """Under forces that the basis has not seen; most of the way is the swing about the hinges."""
    robot, q = equilibria
    body = reducible(robot)
    deviations = body.deviations(q)
    modes = pod(without_own(body, deviations), body.weight, 4)
    every = np.arange(body.n_elements)
    basis = basis_of(robot, with_own(body, modes.Phi), every, np.ones(len(every)))
    reduced = reduced_robot(robot, basis)
    full, small = Simulator(robot, "none"), Simulator(reduced, "none")
    rest = robot.effector(robot.rest())[0]
    ways, errors = [], []
    for force in np.random.default_rng(5).uniform(-0.8, 0.8, size=(3, 3)) * [0.02, 0.05, 0.05]:
        assert full.settle(effort=force).converged
        assert small.settle(effort=force).converged
        there = robot.effector(full.state)[0]
        ways.append(np.linalg.norm(there - rest))
        errors.append(np.linalg.norm(reduced.effector(small.state)[0] - there))
    assert max(ways) > 0.01
    assert max(errors) < 1e-4 * max(ways)


@pytest.mark.slow
def test_hinges_in_modes_swing_to_second_order(
    equilibria: tuple[Robot[ConstrainedBody], Array],
) -> None:
    """Released, beside steps of an eighth: centrifugal forces are those at the end of a stage."""
    robot, q = equilibria
    body, every = reducible(robot), np.arange(reducible(robot).n_elements)
    modes = pod(without_own(body, body.deviations(q)), body.weight, 4)
    basis = basis_of(robot, with_own(body, modes.Phi), every, np.ones(len(every)))
    resting = Simulator(reduced_robot(robot, basis), "none")
    assert resting.settle(effort=[0.02, 0.05, 0.05]).converged
    scheme = replace(robot.integration, static=False, rayleigh_stiffness=2e-3)
    swinging, ways = resting.robot.with_integration(scheme), []
    for steps in (32, 4, 8):
        simulator = Simulator(swinging, "none")
        simulator.start_from(resting.state)
        way = []
        for _ in range(12):
            simulator.move(effort=np.zeros(3), steps=steps)
            way.append(simulator.effector[0].copy())
        ways.append(np.array(way))
    coarse, fine = (np.abs(way - ways[0]).max() for way in ways[1:])
    assert np.abs(ways[0] - ways[0][0]).max() > 100.0 * coarse
    assert fine < 0.29 * coarse, "a quarter by second order"


TENDON = {"max_tension": 50.0, "max_pull": 0.05, "max_rate": 1.0,
          "spring": {"stiffness": 2e3, "pretension": 2.0}}  # fmt: skip


def drum_and_hinge() -> Robot[ConstrainedBody]:
    """A soft bar with a rigid plate at its end, a rigid box on a hinge on that, two cables on a drum."""
    plate = {"body": "soft", "lower": [0.049, 0.0, 0.0], "upper": [0.06, 0.02, 0.02]}
    return joined(
        [
            {"name": "soft", "fixed": [{"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}]},
            {"name": "box", "rigid": True, "position": [0.06, 0.0, 0.0]},
        ],
        {"soft": SOFT, "box": BOX},
        rigid=[{"name": "plate", "region": plate}],
        attachments=[
            {
                "kind": "hinge", "region": {"kind": "all", "body": "box"}, "to": plate,
                "through": [0.06, 0.01, 0.01], "axis": [0.0, 1.0, 0.0], "tilt_stiffness": 0.5,
            }
        ],
        cables=[
            {"name": name, "points": [[0.0, 0.01, z], [0.03, 0.01, z], [0.08, 0.01, z]], **TENDON}
            for name, z in (("lower", 0.002), ("upper", 0.018))
        ],
        couplings=[
            {
                "name": "drum", "kind": "drum", "members": ["lower", "upper"], "gains": [1.0, -1.0],
                "max_position": 0.02, "max_effort": 100.0, "max_rate": 0.5,
            }
        ],
        effectors=[{"name": "end", "point": [0.08, 0.01, 0.01]}],
    )  # fmt: skip


def complete(robot: Robot) -> Robot:
    """The robot in as many modes as its free nodes have directions, and its own coordinates."""
    body = reducible(robot)
    count = len(body.weight) - body.own_coordinates
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(count, count)))[0]
    Phi = np.zeros((len(body.weight), count))
    Phi[:count] = turn / np.sqrt(body.weight[:count, None])
    every = np.arange(body.n_elements)
    return body.reduced(with_own(body, Phi), every, np.ones(len(every)))


@pytest.mark.parametrize("aside", [[0.0, 0.0], [0.3, -0.2], [3.0, -9.0]])
def test_a_body_on_a_pin_hangs_in_modes_where_the_full_one_does(aside: list[float]) -> None:
    """It turns freely about the line to its pin, and no search found where it rests."""
    box = {"kind": "all", "body": "box"}
    robot = joined(
        [
            {"name": "soft", "fixed": [{"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}]},
            {"name": "box", "rigid": True, "position": [0.06, 0.0, 0.0]},
        ],
        {"soft": SOFT, "box": BOX},
        attachments=[
            {
                "kind": "pin", "region": box, "to": {"kind": "all", "body": "soft"},
                "through": [0.06, 0.01, 0.01],
            }
        ],
        gravity=[9.81, *aside],
        effectors=[{"name": "centre", "kind": "centre", "region": box}],
    )  # fmt: skip
    full, small = Simulator(robot, "none"), Simulator(complete(robot), "none")
    for simulator in (full, small):
        report = simulator.settle(effort=[0.0])
        assert report.converged and report.iterations < 60
    np.testing.assert_allclose(small.effector, full.effector, atol=1e-7)


@pytest.mark.long
@pytest.mark.parametrize("make", [chain, drum_and_hinge])
def test_a_complete_basis_is_the_full_robot(make: Callable[[], Robot]) -> None:
    """The same unknowns, equilibria and first step: rigid regions and parts on hinges are exactly rigid."""
    robot = make()
    reduced = complete(robot)
    assert reduced.n == robot.n
    commands = [{"effort": force} for force in FORCES[:2]]
    if make is drum_and_hinge:
        commands = [{"position": [0.002]}, {"effort": [-6.0]}]
    rest = robot.effector(robot.rest())[0]
    for command in commands:
        full, small = Simulator(robot, "none"), Simulator(reduced, "none")
        for simulator in (full, small):
            assert simulator.settle(**command).converged
        assert np.linalg.norm(full.effector[0] - rest) > 3e-3
        np.testing.assert_allclose(small.effector, full.effector, atol=1e-8)
        np.testing.assert_allclose(small.effort, full.effort, atol=1e-6)
        for simulator in (full, small):
            simulator.reset()
            simulator.step(**command)
        np.testing.assert_allclose(small.effector, full.effector, atol=1e-8)


@pytest.mark.long
def test_the_springs_of_a_hinge_hold_it_in_modes(
    equilibria: tuple[Robot[ConstrainedBody], Array],
) -> None:
    """Forces of all modes, at a state in their span, are those of the nodes: the power of a motion."""
    robot, q = equilibria
    body = reducible(robot)
    modes = pod(without_own(body, body.deviations(q)), body.weight, 22)
    every = np.arange(body.n_elements)
    Phi = with_own(body, modes.Phi)
    reduced = reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))
    assert robot.body.joints is not None
    assert robot.body.joints.springs.shape[0] > 0
    for column in (0, 7, 19):
        state = projected(reduced, State(q[:, column], np.zeros(robot.n)))
        force = reduced.forces(state)[0]
        # the same nodes in the full robot: elements, gravity and springs
        beta = reduced.motion(state).beta
        raw = robot.body.tetrahedra
        x = raw.placed(raw.at_rest + reduced.body.E @ beta)
        spring = robot.body.joints.springs
        on_nodes = (spring.T @ (spring @ x.ravel())).reshape(-1, 3)
        force_on_nodes = -on_nodes
        raw.elements.assemble(x, NO_TANGENT, force_on_nodes, np.zeros(0))
        over_beta = reduced.body.E.T @ (force_on_nodes[raw.dof >= 0].ravel() + raw.load)
        J = reduced.motion(state).J
        assert J is not None
        expected = J.forces(over_beta)
        np.testing.assert_allclose(force, expected, atol=1e-8 * np.abs(expected).max())


@pytest.mark.long
def test_the_tangent_is_the_derivative_of_the_forces(
    equilibria: tuple[Robot[ConstrainedBody], Array],
) -> None:
    robot, q = equilibria
    body = reducible(robot)
    modes = pod(without_own(body, body.deviations(q)), body.weight, 20)
    every = np.arange(body.n_elements)
    reduced = reduced_robot(
        robot, basis_of(robot, with_own(body, modes.Phi), every, np.ones(len(every)))
    )
    state = projected(reduced, State(q[:, 3], np.zeros(robot.n)))
    direction, step = np.random.default_rng(2).normal(size=reduced.n), 1e-7
    ahead, behind = (
        reduced.forces(State(state.q + sign * step * direction, state.v))[0] for sign in (1.0, -1.0)
    )
    _, K = reduced.forces(state, exact=True)
    difference = -(ahead - behind) / (2.0 * step)
    np.testing.assert_allclose(K @ direction, difference, atol=1e-5 * np.abs(difference).max())


def test_rotations_are_those_of_their_vectors() -> None:
    """Against SciPy, from no angle to more than a turn."""
    none = np.zeros(0, dtype=np.int64)
    motion = OwnMotion(1, 0, none, 0, 5, np.zeros(5), 1, 1)
    vectors = np.random.default_rng(0).normal(size=(5, 3))
    for angle in (0.0, 1e-12, 1e-7, 0.3, np.pi, 7.0):
        phi = angle * vectors / np.linalg.norm(vectors, axis=1)[:, None]
        found = motion.rotations(np.concatenate([[0.0], phi.ravel()]))
        np.testing.assert_allclose(found, Rotation.from_rotvec(phi).as_matrix(), atol=1e-15)
