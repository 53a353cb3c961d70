"""Motion between two commands against an integrator of variable order and step (scipy's Radau)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.robots.bodies import beam_config, box_mesh
from support.robots.small_bodies import ROOT, RUBBER, SLIDE, constrained

from tauten.model import Robot, Simulator, State
from tauten.model.load import build_robot
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig
from tauten.model.tetra import NodalBody

SIZE = (0.1, 0.01, 0.01)
PULLING = 8.0  # N, largest tension of the cable
TICKS = 8


def damped_beam(of_stiffness: float, of_mass: float) -> Robot[NodalBody]:
    """A soft beam with a cable along one side, at 50 Hz."""
    damping = {"rayleigh_stiffness": of_stiffness, "rayleigh_mass": of_mass}
    config = RobotConfig.model_validate(beam_config(SIZE, integration=damping))
    return build_robot(config, box_mesh(SIZE, (3, 1, 1)), "beam")


@pytest.fixture(scope="module")
def beam() -> Robot[NodalBody]:
    return damped_beam(0.02, 0.5)


def dense(robot: Robot[NodalBody], values: Array) -> Array:
    """A matrix (n, n) from values in the robot's pattern."""
    matrix = np.zeros((robot.n, robot.n))
    columns = np.repeat(np.arange(robot.n), np.diff(robot.body.pattern.indptr))
    matrix[robot.body.pattern.indices, columns] = values
    return matrix


def efforts() -> Array:
    """Tension at the end of each tick (ticks,) [N]: up, and half back."""
    return PULLING * np.interp(np.arange(1, TICKS + 1), [0.0, 4.0, TICKS], [0.0, 1.0, 0.5])


def exact_tips(robot: Robot[NodalBody]) -> Array:
    """Tips (ticks, 3) of M dv/dt = f + H_aᵀ λ_a − C v; the tension grows evenly within a tick."""
    n, scheme, levels = robot.n, robot.integration, np.append(0.0, efforts())

    def rate(t: float, y: Array) -> Array:
        state = State(y[:n], y[n:])
        lam = np.array([np.interp(t / robot.h, np.arange(TICKS + 1), levels)])
        force, D = robot.forces(state)
        damping = scheme.rayleigh_mass * robot.body.tetrahedra.mass * state.v
        damping += scheme.rayleigh_stiffness * dense(robot, D) @ state.v
        pulled = lam @ robot.rows(state, contacts=False).actuators.dense()
        return np.concatenate([state.v, (force + pulled - damping) / robot.body.tetrahedra.mass])

    times = robot.h * np.arange(1, TICKS + 1)
    start = np.concatenate([robot.rest().q, np.zeros(n)])
    found = solve_ivp(rate, (0.0, times[-1]), start, "Radau", times, rtol=1e-5, atol=1e-8)
    return np.array([robot.effector(State(y[:n], y[n:]))[0] for y in found.y.T])


def moved_tips(robot: Robot[NodalBody], steps: int) -> Array:
    """Tips (ticks, 3) of a simulation with some steps in a tick."""
    simulator, found = Simulator(robot, contact="none"), []
    for effort in efforts():
        simulator.move(effort=[effort], steps=steps)
        found.append(simulator.effector[0])
    return np.array(found)


@pytest.mark.long
def test_steps_are_of_second_order(beam: Robot[NodalBody]) -> None:
    """Half as long, a quarter of the error; one a period is off by less than 1 % of the way.

    Ticks in which a single step leads too far are divided, so that the first two errors are alike.
    """
    exact = exact_tips(beam)
    way = np.linalg.norm(exact - beam.effector(beam.rest())[0], axis=1).max()
    errors = [np.linalg.norm(moved_tips(beam, k) - exact, axis=1).max() for k in (1, 2, 4, 8)]
    assert way > 0.1 * SIZE[0]
    assert errors[0] < 0.01 * way
    assert errors[2] < 0.3 * errors[1]
    assert errors[3] < 0.3 * errors[2]


@pytest.mark.parametrize("between", ["step", "settle"])
def test_actuators_move_on_from_where_a_step_or_a_settling_has_brought_them(
    beam: Robot[NodalBody], between: str
) -> None:
    """A cable that is held at the position of an equilibrium does not go back to an earlier `move`."""
    simulator = Simulator(beam, contact="none")
    simulator.move(position=[0.0])
    for _ in range(60 if between == "step" else 1):
        getattr(simulator, between)(position=[0.005])
    tip, tension = simulator.effector[0], simulator.effort[0]
    simulator.move(position=[0.005])
    np.testing.assert_allclose(simulator.effector[0], tip, atol=1e-4 * SIZE[0])
    assert simulator.effort[0] == pytest.approx(tension, rel=1e-2)


@pytest.mark.parametrize(("of_stiffness", "of_mass"), [(5e-4, 0.0), (0.0, 10.0)])
def test_a_damped_oscillation_has_the_frequency_and_decay_of_its_mode(
    of_stiffness: float, of_mass: float
) -> None:
    """A small motion in the first mode against the closed solution of a damped oscillator."""
    light = damped_beam(of_stiffness, of_mass)
    _, values = light.forces(light.rest(), exact=True)
    K, root = dense(light, values), np.sqrt(light.body.tetrahedra.mass)
    squares, modes = np.linalg.eigh(K / np.outer(root, root))
    omega = np.sqrt(squares[0])
    decay = 0.5 * (of_mass + of_stiffness * omega**2)
    beat = np.sqrt(omega**2 - decay**2)
    shape = 1e-5 * modes[:, 0] / root / np.abs(modes[:, 0] / root).max()  # (n,) m
    simulator = Simulator(light, contact="none")
    simulator.start_from(State(light.rest().q + shape, np.zeros(light.n)))
    tip = simulator.effector[0] - light.effector(light.rest())[0]
    steps = int(np.ceil(40.0 * beat * light.h / (2.0 * np.pi)))  # 40 in a vibration
    for tick in range(1, 6):
        simulator.move(effort=[0.0], steps=steps)
        t = tick * light.h
        share = np.exp(-decay * t) * (np.cos(beat * t) + decay / beat * np.sin(beat * t))
        moved = simulator.effector[0] - light.effector(light.rest())[0]
        assert np.linalg.norm(moved - share * tip) < 0.02 * np.linalg.norm(tip)


@pytest.mark.long
def test_a_force_that_changes_its_sign_leaves_the_order_of_the_steps() -> None:
    """A slider moves the root of a bar to and fro: nothing begins where it pulls instead of pushing."""
    robot = constrained(
        box_mesh((0.1, 0.02, 0.02), (8, 1, 1)), fixed=[], cables=None, controller={"rate": 50.0},
        drives=[{**SLIDE, "region": ROOT, "axis": [0.0, 0.0, 1.0]}],
        material={**RUBBER, "young_modulus": 3e5},
        integration={"rayleigh_stiffness": 0.05, "rayleigh_mass": 5.0},
    )  # fmt: skip
    tips, forces = {}, np.zeros(20)
    for steps in (1, 2, 16):
        simulator, found = Simulator(robot, contact="none"), []
        for tick in range(20):
            way = 0.01 * np.sin(4.0 * np.pi * 0.02 * (tick + 1)) ** 2
            simulator.move(position=[way], steps=steps)
            found.append(simulator.effector[0])
            forces[tick] = simulator.effort[0]
        tips[steps] = np.array(found)
    assert (np.diff(np.sign(forces)) != 0.0).sum() >= 2
    coarse, fine = (np.abs(tips[steps] - tips[16]).max() for steps in (1, 2))
    assert fine < 1e-5
    assert coarse > 3.0 * fine, "a quarter by second order, a half by first"


def test_no_steps_are_refused(beam: Robot[NodalBody]) -> None:
    with pytest.raises(ValueError, match="steps: found 0, expected a whole number of at least 1"):
        Simulator(beam, contact="none").move(effort=[0.0], steps=0)


@pytest.mark.long
@pytest.mark.parametrize("steps", [1, 4])
def test_the_effort_after_a_move_accelerates_what_a_slider_carries(steps: int) -> None:
    """M a of a body on a slider that goes to and fro, where the force of the last stage is -4.8 M a.

    It is half a period late: the velocity of the slider jumps where a period begins.
    """
    slider = {**SLIDE, "axis": [0.0, 0.0, 1.0], "region": {"kind": "all"}, "max_force": 1e4}
    robot = constrained(
        box_mesh(SIZE, (2, 1, 1)), drives=[slider], cables=[], fixed=[], controller={"rate": 100.0},
        effectors=[{"name": "centre", "kind": "centre", "region": {"kind": "all"}}],
    )  # fmt: skip
    mass = 1000.0 * np.prod(SIZE)
    simulator, way, omega, found = Simulator(robot, contact="none"), 0.005, 10.0, []
    times = robot.h * np.arange(1, 101)
    for time in times:
        simulator.move(position=[way * (1.0 - np.cos(omega * time))], steps=steps)
        found.append(simulator.effort[0])
    late = mass * way * omega**2 * np.cos(omega * (times - 0.5 * robot.h))
    np.testing.assert_allclose(found[2:], late[2:], atol=0.01 * late.max())
