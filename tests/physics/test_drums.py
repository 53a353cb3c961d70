"""Drums: finite differences, statics of an antagonistic pair, cables that go slack, control."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from support.robots.bodies import beam_config
from support.robots.joined import joined, rod
from support.robots.small_bodies import MESH, SIZE, constrained, moved
from support.state_bases import basis_of

from tauten.controller import Controller
from tauten.model import Robot, Simulator, State
from tauten.model.constraints import ConstrainedBody
from tauten.model.load import build_robot
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig, RobotFileError, validated
from tauten.reduction.state import reduced_robot, reducible

STIFFNESS, PRETENSION = 5e3, 2.0
LIMITS = {"max_tension": 50.0, "max_pull": 0.05, "max_rate": 1.0}


def tendon(name: str, z: float, y: float = 0.01, **changes: object) -> dict[str, object]:
    """A cable along a bar of 0.1 m x 0.02 m x 0.02 m at the height z."""
    spring = {"stiffness": STIFFNESS, "pretension": PRETENSION}
    points = [[0.01, y, z], [0.05, y, z], [0.1, y, z]]
    return {"name": name, "points": points, "spring": spring, **LIMITS, **changes}


DRUM: dict[str, object] = {
    "name": "drum", "kind": "drum", "members": ["lower", "upper"], "gains": [1.0, -1.0],
    "max_position": 0.02, "max_effort": 100.0, "max_rate": 0.5,
}  # fmt: skip


def antagonists(**changes: object) -> Robot[ConstrainedBody]:
    """A soft bar with a cable below and one above on one drum."""
    cables = [tendon("lower", 0.002), tendon("upper", 0.018)]
    given = {"cables": cables, "couplings": [DRUM], "integration": {"scheme": "quasi-static"}}
    return constrained(**{**given, **changes})


def pulled(robot: Robot[ConstrainedBody], simulator: Simulator) -> tuple[Array, Array]:
    """Pulled lengths [m] and tensions [N] of all cables."""
    state = simulator.state
    rows, efforts = robot.body.wound(robot.motion(state))
    return rows.delta, efforts


@pytest.mark.parametrize("y", [0.01, 0.001])
def test_forces_and_tangent_are_derivatives_of_the_energy(y: float) -> None:
    """At a state with one cable taut and one slack, rows of the motor included; also along the first node."""
    robot = antagonists(cables=[tendon("lower", 0.002, y), tendon("upper", 0.018, y)])
    rng = np.random.default_rng(3)
    dq = 5e-4 * rng.standard_normal(robot.n)
    dq[-1] = 3e-3
    state = moved(robot, robot.rest(), dq)
    efforts = robot.body.wound(robot.motion(state))[1]
    assert efforts[0] > 1.0
    assert efforts[1] == 0.0
    d, step = rng.standard_normal(robot.n), 1e-7

    def slope(value: object) -> Array:
        ahead, behind = (value(moved(robot, state, sign * step * d)) for sign in (1.0, -1.0))  # type: ignore[operator]
        return np.asarray((ahead - behind) / (2.0 * step))

    force, K = robot.forces(state, np.zeros(1), exact=True)
    assert -force @ d == pytest.approx(float(slope(robot.potential)), rel=1e-6)
    matrix = sp.csc_array(
        (K, robot.body.pattern.indices, robot.body.pattern.indptr), shape=(robot.n,) * 2
    )
    found = -slope(lambda at: robot.forces(at)[0])
    assert np.abs(matrix @ d - found).max() < 2e-6 * np.abs(found).max()
    rows = robot.rows(state).actuators
    assert rows.H @ d == pytest.approx(d[-1:])
    assert rows.delta == pytest.approx([3e-3])


def test_the_motor_bears_the_difference_of_the_tensions() -> None:
    """Given a position, each cable has the tension of its spring, and the effort is Σ g λ; both differ."""
    robot = antagonists()
    simulator = Simulator(robot, contact="none")
    for position in (0.001, 0.003, -0.002):
        assert simulator.settle(position=[position], effort=[np.nan]).converged
        delta, effort = pulled(robot, simulator)
        wound = position * np.array([1.0, -1.0])
        expected = np.maximum(PRETENSION + STIFFNESS * (wound - delta), 0.0)
        assert effort == pytest.approx(expected, abs=1e-9)
        assert simulator.effort[0] == pytest.approx(effort[0] - effort[1], abs=1e-6)
        assert abs(effort[0] - effort[1]) > 0.1


def test_work_of_the_motor_is_the_energy_stored() -> None:
    """Trapezoidal sum of the effort over the position, from where the pretensions hold each other."""
    robot = antagonists()
    simulator = Simulator(robot, contact="none")
    positions = np.linspace(0.0, 0.004, 41)
    energy, effort = [], []
    for position in positions:
        assert simulator.settle(position=[position], effort=[np.nan]).converged
        energy.append(robot.potential(simulator.state))
        effort.append(simulator.effort[0])
    assert robot.potential(robot.rest()) == pytest.approx(
        0.0, abs=1e-12
    )  # energies count from there
    work = float(np.trapezoid(effort, positions))
    assert work == pytest.approx(energy[-1] - energy[0], rel=3e-4)


def test_a_stiff_drum_is_two_winches_at_the_lengths_that_it_winds() -> None:
    """Where both springs are stiff: the same shape and tensions as two cables of their own at g θ."""
    stiff = {"stiffness": 1e7, "pretension": PRETENSION}
    cables = [tendon("lower", 0.002, spring=stiff), tendon("upper", 0.018, spring=stiff)]
    drum = Simulator(antagonists(cables=cables), contact="none")
    assert drum.settle(position=[0.002], effort=[np.nan]).converged
    winches = [
        {key: value for key, value in cable.items() if key != "spring"} | {"min_pull": -0.02}
        for cable in cables
    ]
    config = validated(RobotConfig, beam_config(SIZE, cables=winches), "bar.toml")
    two = Simulator(build_robot(config, MESH, "bar.toml"), contact="none")
    length = PRETENSION / 1e7
    assert two.settle(position=[0.002 + length, -0.002 + length]).converged
    assert drum.robot.effector(drum.state) == pytest.approx(two.robot.effector(two.state), abs=1e-6)


DAMPED = {"scheme": "implicit-euler", "rayleigh_stiffness": 0.05}


def all_modes(robot: Robot[ConstrainedBody]) -> Robot:
    """The reduced robot with as many modes as the full one has unknowns, and with every element."""
    root = np.sqrt(reducible(robot).weight[:-1])
    every = np.arange(robot.body.n_elements)
    Phi = np.diag(np.append(1.0 / root, 1.0))
    return reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))


@pytest.mark.parametrize("reduced", [False, True], ids=["full", "reduced"])
def test_a_drum_of_one_cable_moves_as_a_winch_with_the_same_spring(reduced: bool) -> None:
    """In motion too: damping is that of the material, a spring has none."""
    cables = [tendon("lower", 0.002)]
    motion = {"integration": DAMPED, "controller": {"rate": 200.0}}
    coupling = {**DRUM, "members": ["lower"], "gains": [1.0]}
    robot = antagonists(cables=cables, couplings=[coupling], **motion)
    drum = Simulator(all_modes(robot) if reduced else robot, contact="none")
    config = validated(RobotConfig, beam_config(SIZE, cables=cables, **motion), "bar.toml")
    winch = Simulator(build_robot(config, MESH, "bar.toml"), contact="none")
    assert drum.settle(position=[0.0], effort=[np.nan]).converged
    assert winch.settle(position=[0.0]).converged
    for step in range(20):
        position = [1e-3 * min(step, 8)]
        drum.move(position=position, effort=[np.nan])
        winch.move(position=position)
        way = np.linalg.norm(winch.effector - winch.robot.effector(winch.robot.rest()))
        assert drum.effector == pytest.approx(winch.effector, abs=way / 100.0)
        assert drum.effort == pytest.approx(winch.effort, rel=1.1e-2)
    assert way > 5e-3


@pytest.mark.long
def test_a_drum_on_a_rod_goes_slack_and_is_controlled() -> None:
    """One motor brings the tip of a rod with a pair of tendons to a height, and back beyond the middle."""
    tendons = [
        {
            "name": name, "points": [[0.0, 0.0, z], [0.05, 0.0, z], [0.1, 0.0, z]], "max_outside": 0.01,
            "spring": {"stiffness": 2e3, "pretension": 0.5}, **LIMITS,
        }
        for name, z in (("lower", -0.008), ("upper", 0.008))
    ]  # fmt: skip
    root = {"body": "rod", "kind": "sphere", "centre": [0.0, 0.0, 0.0], "radius": 1e-6}
    robot = joined(
        [rod("rod", [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]], fixed=[root])],
        cables=tendons,
        couplings=[{**DRUM, "members": ["upper", "lower"]}],
        effectors=[{"name": "tip", "point": [0.1, 0.0, 0.0], "weight": [0.0, 0.0, 1.0]}],
        integration={"scheme": "implicit-euler", "rayleigh_stiffness": 0.02},
        controller={"rate": 100.0},
    )
    controller = Controller(robot)
    for height in (0.02, -0.015):
        for _ in range(50):
            decision = controller.decide(np.array([0.1, 0.0, height]))
            assert decision.status.usable
            controller.advance()
        assert robot.effector(controller.state)[0, 2] == pytest.approx(height, abs=2e-4)
        effort = robot.body.wound(robot.motion(controller.state))[1]
        assert effort.min() >= 0.0
        assert effort.max() > 0.5


@pytest.mark.parametrize("exact", [False, True])
def test_a_drum_in_modes_is_that_of_the_full_robot(exact: bool) -> None:
    """Forces, tangent and rows in random modes with every element, one cable taut and one slack."""
    robot = antagonists()
    body = reducible(robot)
    free, modes = robot.n - 1, 8
    Phi = np.zeros((robot.n, modes + 1))
    random = np.linalg.qr(np.random.default_rng(0).normal(size=(free, modes)))[0]
    Phi[:free, :modes], Phi[free, modes] = random / np.sqrt(body.weight[:-1, None]), 1.0
    every = np.arange(body.n_elements)
    reduced = reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))
    q = np.append(3e-4 * np.random.default_rng(1).normal(size=modes), 3e-3)
    state, lam = State(q, np.zeros(modes + 1)), np.array([0.4])
    lifted = reduced.body.lifted(state)
    assert (robot.body.wound(robot.motion(lifted))[1] > 0.0).tolist() == [True, False]
    force, K = reduced.forces(state, lam, exact)
    full_force, values = robot.forces(lifted, lam, exact)
    full = sp.csc_array(
        (values, robot.body.pattern.indices, robot.body.pattern.indptr), (robot.n,) * 2
    )
    np.testing.assert_allclose(force, Phi.T @ full_force, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(K, Phi.T @ (full @ Phi), atol=1e-9 * np.abs(K).max())
    found, there = reduced.rows(state).actuators, robot.rows(lifted).actuators
    np.testing.assert_allclose(found.delta, there.delta, atol=1e-15)
    np.testing.assert_allclose(found.dense(), there.dense() @ Phi, atol=1e-12)


def test_a_drum_needs_cables_with_springs() -> None:
    bare = [tendon("lower", 0.002), tendon("upper", 0.018)]
    del bare[1]["spring"]
    with pytest.raises(RobotFileError, match="'upper' on a drum has to be a cable with a spring"):
        antagonists(cables=bare)
    with pytest.raises(RobotFileError, match="the cables of a drum have theirs in `spring`"):
        antagonists(couplings=[{**DRUM, "pretensions": [1.0, 1.0]}])


def test_cables_of_a_drum_are_drawn_as_its_own() -> None:
    """Beside a cable that is alone and stands first, the other two belong to the second motor."""
    alone = {**tendon("side", 0.01)}
    del alone["spring"]
    robot = antagonists(cables=[alone, tendon("lower", 0.002), tendon("upper", 0.018)])
    assert robot.actuators.names == ("side", "drum")
    assert robot.actuator_set.segment_owners.tolist() == [0, 0, 1, 1, 1, 1]
    rows = robot.rows(moved(robot, robot.rest(), np.append(np.zeros(robot.n - 1), 0.01))).actuators
    assert rows.delta == pytest.approx([0.0, 0.01])
