"""Converged time steps of robots with rigid regions, pins, drives, glue, beams and drums."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support.robots.bodies import beam_robot, body_inertia, box_mesh
from support.robots.joined import joined, push, rod
from support.robots.small_bodies import (
    END,
    FIRST,
    GLUE,
    HINGE,
    LAST,
    MESH,
    MIDDLE,
    ROOT,
    RUBBER,
    SECOND,
    SIZE,
    SLIDE,
    TURN,
    constrained,
    moved,
    rigid_box,
)

from tauten.model import Robot, Simulator, State
from tauten.model.constraints import ConstrainedBody
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array

G = 9.81
DOWN = [0.0, 0.0, -G]
STIFF = {**RUBBER, "young_modulus": 1e9}
EVERYWHERE = {"kind": "hinge", "region": {"kind": "all"}, "axis": [0.0, 1.0, 0.0]}
LINE = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]
SPRING = {"stiffness": 5e3, "pretension": 2.0}
LIMITS = {"max_tension": 50.0, "max_pull": 0.05, "max_rate": 1.0}


def mixed() -> Robot[ConstrainedBody]:
    """Two soft bodies, glued, with a rigid plate, a servo, a slider and a hinge on the frame."""
    return constrained(
        [MESH, MESH], mesh=None, fixed=[], bodies=[FIRST, SECOND], material=RUBBER, gravity=DOWN,
        attachments=[GLUE, HINGE],
        rigid=[{"name": "plate", "region": {**END, "body": "first"}}],
        drives=[{**TURN, "region": MIDDLE}, {**SLIDE, "region": LAST}],
        controller={"rate": 200.0},
    )  # fmt: skip


def chain() -> Robot[ConstrainedBody]:
    """A soft bar, a rigid box that hangs from its end by a pin, and a beam that is glued to the box."""
    start = {"body": "rod", "kind": "sphere", "centre": LINE[0], "radius": 1e-6}
    box, soft = ({"kind": "all", "body": name} for name in ("box", "soft"))
    return joined(
        [
            {"name": "soft", "position": [0.0, -0.005, -0.005], "fixed": [ROOT]},
            {"name": "box", "rigid": True, "position": [0.1, -0.005, -0.02]},
            rod("rod", LINE, position=[0.11, 0.0, -0.01], elements=4),
        ],
        {"soft": ((0.1, 0.01, 0.01), (6, 1, 1)), "box": ((0.01, 0.01, 0.02), (1, 1, 1))},
        attachments=[
            {"kind": "pin", "region": box, "through": [0.1, 0.0, 0.0], "to": soft},
            {"kind": "glue", "region": start, "to": box},
        ],
        gravity=DOWN, forces=[push("push", [0.1, 0.0, 0.0], [0.0, 0.0, 1.0])],
        integration={"scheme": "implicit-euler"}, controller={"rate": 200.0},
    )  # fmt: skip


def wound() -> Robot[ConstrainedBody]:
    """A soft bar with a cable below and one above on one drum."""
    cables = [
        {"name": name, "points": [[0.01, 0.01, z], [0.1, 0.01, z]], "spring": SPRING, **LIMITS}
        for name, z in (("lower", 0.002), ("upper", 0.018))
    ]
    drum = {
        "name": "drum", "kind": "drum", "members": ["lower", "upper"], "gains": [1.0, -1.0],
        "max_position": 0.02, "max_effort": 100.0, "max_rate": 0.5,
    }  # fmt: skip
    return constrained(
        box_mesh(SIZE, (4, 1, 1)), cables=cables, couplings=[drum], controller={"rate": 200.0}
    )


ROBOTS = [mixed, chain, wound]


def shaken(robot: Robot[ConstrainedBody], speed: float) -> State:
    """At rest in place, with velocities of nodes and regions of about this speed [m/s]."""
    v = speed * np.random.default_rng(4).standard_normal(robot.n)
    first = 3 * len(robot.body.coordinates.free)
    v[first + robot.body.frames.rotations[:, None] + np.arange(3)] *= 50.0  # rad/s
    v[first + robot.body.frames.drives] = 0.0
    return State(robot.rest().q, v)


def swing(robot: Robot[ConstrainedBody], start: State, steps: int, **command: Array) -> Array:
    """Energy (steps + 1,) [J] of a motion under constant actuators."""
    simulator = Simulator(robot, contact="none")
    simulator.start_from(start)
    energies = [robot.energy(start)]
    for _ in range(steps):
        assert simulator.step(**command, converged=True).converged
        energies.append(robot.energy(simulator.state))
    return np.array(energies)


@pytest.mark.parametrize("make", ROBOTS)
def test_the_balance_of_a_step_is_the_derivative_of_its_potential(
    make: Callable[[], Robot[ConstrainedBody]],
) -> None:
    """Central differences of Φ at an iterate far from the start are what an iteration has out of balance."""
    robot = make()
    scheme = replace(robot.integration, rayleigh_mass=3.0, rayleigh_stiffness=1e-3)
    robot = robot.with_integration(scheme)
    rng = np.random.default_rng(5)
    start = robot.body.step_start(shaken(robot, 0.1))
    state = moved(robot, start.state, robot.h * shaken(robot, 0.05).v)

    def potential(at: State) -> float:
        return robot.body.step_energy(
            start, robot.body.velocity(start.state, at)
        ) + robot.potential(at)

    system = robot.body.linearise_iterate(state, start, np.zeros(robot.n_a))
    for _ in range(3):
        e = rng.standard_normal(robot.n)
        d = system.solve(e[:, None])[:, 0]  # so that d · balance = e · A⁻¹ balance
        scale = 1e-4 / np.abs(d).max()
        near, behind, far, beyond = (
            potential(moved(robot, state, times * scale * d)) for times in (1.0, -1.0, 2.0, -2.0)
        )
        slope = (8.0 * (near - behind) - (far - beyond)) / (12.0 * scale)  # of fourth order
        assert -system.v_free @ e / robot.h == pytest.approx(slope, rel=1e-5)


def test_a_compound_pendulum_takes_implicit_eulers_steps() -> None:
    """I (ω − ω₀) = h m g s sin θ at the end of every step: one equation in one unknown, by bisection."""
    hinge = {**EVERYWHERE, "through": [0.0, 0.01, 0.02]}
    robot = constrained(
        material=STIFF, fixed=[], gravity=DOWN, attachments=[hinge], controller={"rate": 50.0}
    )
    mass, middle, moments = body_inertia(robot.body.mesh, 1000.0)
    r = middle - np.array([0.0, 0.01, 0.02])
    about = moments[0, 0] + moments[2, 2] + mass * (r[0] ** 2 + r[2] ** 2)  # kg m²
    centre = mass * r  # kg m
    h, theta, omega = robot.h, 0.0, 0.0
    simulator = Simulator(robot, contact="none")
    for _ in range(40):
        assert simulator.step(effort=np.zeros(robot.n_a), converged=True).converged

        def balance(w: float, at: float = theta, before: float = omega) -> float:
            angle = at + h * w
            lever = centre[0] * np.cos(angle) + centre[2] * np.sin(angle)
            return about * (w - before) / h - G * lever

        omega = float(brentq(balance, -100.0, 100.0, xtol=1e-12))
        theta += h * omega
        assert simulator.state.q[-1] == pytest.approx(theta, abs=1e-5)
    assert abs(theta) > 1.0, "it has swung far"


@pytest.mark.long
@pytest.mark.parametrize("make", ROBOTS)
def test_energy_never_grows_while_motors_hold(make: Callable[[], Robot[ConstrainedBody]]) -> None:
    """From wild velocities; drives and drums are held, cables slack."""
    robot = make()
    position = np.where([one in ("tendon", "push") for one in robot.actuators.names], np.nan, 0.0)
    effort = np.where(np.isnan(position), 0.0, np.nan)
    energies = swing(robot, shaken(robot, 0.5), 25, position=position, effort=effort)
    assert np.diff(energies).max() < 1e-12 * np.abs(energies).max(), "beyond rounding"
    assert energies[-1] < energies[0]


def test_energy_grows_by_no_more_than_the_work_of_a_motor() -> None:
    """A servo lifts a soft bar: what it gains is its work, up to what implicit Euler loses."""
    robot = mixed()
    simulator, angle = Simulator(robot, contact="none"), robot.actuators.names.index("servo")
    work, energy, gained = 0.0, robot.energy(robot.rest()), []
    for step in range(40):
        effort = np.zeros(robot.n_a)
        position = np.full(robot.n_a, np.nan)
        before = simulator.position[angle]
        position[angle], effort[angle] = -0.01 * (step + 1), np.nan
        assert simulator.step(position=position, effort=effort, converged=True).converged
        work += simulator.effort[angle] * (simulator.position[angle] - before)
        gained.append(robot.energy(simulator.state) - energy)
        assert gained[-1] <= work + 1e-9
    assert work > 0.0


def tumbled(rate: float, converged: bool) -> tuple[float, float]:
    """Energy relative to the start after half a second, and the error of the body's own spin [rad/s].

    Torque-free, about the unstable axis: Euler's equations by a Runge-Kutta method.

    Args:
        rate: steps in a second.
        converged: whether steps are of implicit Euler and converge; otherwise they are of second order.
    """
    robot = rigid_box(box_mesh((0.1, 0.04, 0.02), (5, 2, 1)), controller={"rate": rate})
    moments = np.diagonal(body_inertia(robot.body.mesh, 1000.0)[2])
    values, omega = moments.sum() - moments, np.array([0.5, 4.0, 1.0])
    start = State(robot.rest().q, np.concatenate([np.zeros(3), omega]))

    def rate_of(_: float, w: Array) -> Array:
        return np.asarray(-np.cross(w, values * w) / values)

    path = solve_ivp(rate_of, (0.0, 0.5), omega, rtol=1e-10, atol=1e-12)
    simulator = Simulator(robot, contact="none")
    simulator.start_from(start)
    for _ in range(int(0.5 * rate)):
        effort = np.zeros(robot.n_a)
        if converged:
            assert simulator.step(effort=effort, converged=True).converged
        else:
            simulator.move(effort=effort)
    last = simulator.state
    inverse = last.q[3:7] * np.array([1.0, -1.0, -1.0, -1.0])
    w, u = inverse[0], inverse[1:]
    across = np.cross(u, last.v[3:])
    own = last.v[3:] + 2.0 * w * across + 2.0 * np.cross(u, across)
    energy = robot.body.kinetic_energy(last) / robot.body.kinetic_energy(start)
    return energy, float(np.abs(own - path.y[:, -1]).max())


@pytest.mark.long
def test_a_tumbling_body_keeps_its_energy_and_follows_eulers_equations() -> None:
    far = []
    for rate in (100.0, 400.0):
        energy, error = tumbled(rate, converged=True)
        assert 0.9 < energy <= 1.0 + 1e-12
        far.append(error)
    assert far[1] < 0.05 * np.linalg.norm([0.5, 4.0, 1.0])
    assert far[0] > 2.5 * far[1], "of first order"


@pytest.mark.long
def test_a_tumbling_body_in_steps_of_second_order_follows_eulers_equations_to_second_order() -> (
    None
):
    (coarse, far), (fine, near) = tumbled(50.0, converged=False), tumbled(200.0, converged=False)
    assert abs(coarse - 1.0) < 5e-5
    assert abs(fine - 1.0) < 0.1 * abs(coarse - 1.0)
    assert near < 3e-5 * np.linalg.norm([0.5, 4.0, 1.0])
    assert near < 0.1 * far, "a sixteenth by second order, a quarter by first"


@pytest.mark.parametrize("make", ROBOTS)
def test_the_first_iteration_is_the_step_with_one_linearisation(
    make: Callable[[], Robot[ConstrainedBody]],
) -> None:
    """Both steps become the same as the time step becomes short, at second order of it or better."""
    plain = make()
    apart = []
    for rate in (400.0, 1600.0):
        robot = plain.with_integration(replace(plain.integration, rate=rate))
        ends = []
        for converged in (False, True):
            simulator = Simulator(robot, contact="none")
            simulator.start_from(shaken(robot, 0.02))
            simulator.step(effort=np.zeros(robot.n_a), converged=converged)
            ends.append(robot.points(simulator.state))
        apart.append(float(np.abs(ends[0] - ends[1]).max()))
    assert apart[0] > 7.0 * apart[1]


def test_a_glued_pair_takes_the_steps_of_one_mesh() -> None:
    """Constraints that constrain nothing: the robot without them, to the tolerance of a step."""
    left = box_mesh((0.05, 0.02, 0.02), (3, 2, 2))
    right = TetMesh(left.nodes + np.array([0.05, 0.0, 0.0]), left.tets)
    nodes, inverse = np.unique(
        np.concatenate([left.nodes, right.nodes]).round(12), axis=0, return_inverse=True
    )
    inverse = inverse.ravel()
    whole = TetMesh(
        nodes, np.concatenate([inverse[left.tets], inverse[len(left.nodes) + right.tets]])
    )
    face = {"body": "right", "lower": [0.05, 0.0, 0.0], "upper": [0.05, 0.02, 0.02]}
    common = {
        "gravity": DOWN, "material": RUBBER, "controller": {"rate": 50.0},
        "integration": {"rayleigh_mass": 1.0, "rayleigh_stiffness": 5e-3},
    }  # fmt: skip
    pair = constrained(
        [left, right], mesh=None, fixed=[],
        bodies=[
            {"name": "left", "mesh": {"file": "a"}, "fixed": [ROOT]},
            {"name": "right", "mesh": {"file": "b"}},
        ],
        attachments=[{"kind": "glue", "region": face, "to": {"kind": "all", "body": "left"}}],
        **common,
    )  # fmt: skip
    one = beam_robot(whole, SIZE, **common)
    order = [int(np.linalg.norm(whole.nodes - x, axis=1).argmin()) for x in pair.body.mesh.nodes]
    first, second = Simulator(pair, contact="none"), Simulator(one, contact="none")
    for _ in range(15):
        for simulator in (first, second):
            assert simulator.step(effort=[8.0], converged=True).converged
    x = one.body.nodes(second.state)[order]
    assert np.abs(x - pair.body.mesh.nodes).max() > 0.01, "it has bent far"
    assert np.abs(pair.body.nodes(first.state) - x).max() < 1e-7
    assert pair.energy(first.state) == pytest.approx(one.energy(second.state), rel=1e-6)


def behind_a_servo(rate: float) -> Simulator:
    """An arm that a servo turns, and one that hangs from its end on a hinge."""
    whole = [{"kind": "all", "body": name} for name in ("upper", "lower")]
    about = {"axis": [0.0, 1.0, 0.0]}
    hinge = {"kind": "hinge", "region": whole[1], "to": whole[0], "max_distance": 0.02, **about}
    robot = joined(
        [
            {"name": "upper", "position": [0.0, -0.01, -0.01]},
            {
                "name": "lower", "rigid": True, "position": [0.09, -0.01, 0.0],
                "rotation": {**about, "angle_deg": 90.0},
            },
        ],
        dict.fromkeys(("upper", "lower"), ((0.1, 0.02, 0.02), (2, 1, 1))),
        attachments=[{**hinge, "through": [0.1, 0.0, 0.0]}],
        drives=[{**TURN, **about, "region": whole[0], "through": [0.0, 0.0, 0.0]}],
        effectors=[{"name": "end", "point": [0.1, 0.0, -0.1]}],
        gravity=DOWN, controller={"rate": rate},
        integration={"scheme": "implicit-euler", "rayleigh_stiffness": 0.05},  # which no hinge feels
    )  # fmt: skip
    return Simulator(robot, contact="none")


@pytest.mark.long
def test_an_arm_on_a_hinge_behind_a_servo_swings_as_lagrange_says() -> None:
    """The servo turns the upper arm by a smooth angle; the lower one follows to first order in the step."""
    length, spin, end = 0.1, 8.0, 0.6

    def angle(t: float) -> float:
        return 1.5 * (t - np.sin(spin * t) / spin)

    def lower(t: float, y: Array) -> list[float]:
        c, s = np.cos(angle(t)), np.sin(angle(t))
        w, dw = 1.5 * (1.0 - np.cos(spin * t)), 1.5 * spin * np.sin(spin * t)
        x, z = (
            -length * (w**2 * c + dw * s),
            length * (w**2 * s - dw * c),
        )  # how the hinge accelerates
        moment = -0.5 * length * (x * np.cos(y[0]) + (z + G) * np.sin(y[0]))
        return [y[1], moment / (length**2 / 3.0 + 0.02**2 / 12.0)]

    aside = solve_ivp(lower, (0.0, end), [0.0, 0.0], rtol=1e-9, atol=1e-12).y[0, -1]
    assert abs(aside) > 0.1
    c, s = np.cos([angle(end), aside]), np.sin([angle(end), aside])
    expected = np.array([length * (c[0] + s[1]), 0.0, -length * (s[0] + c[1])])
    errors = []
    for rate in (100.0, 200.0):
        simulator = behind_a_servo(rate)
        assert simulator.settle(position=[0.0]).converged
        for k in range(round(end * rate)):
            simulator.move(position=[angle((k + 1) / rate)])
        errors.append(simulator.effector[0] - expected)
    assert 2.0 * errors[1] == pytest.approx(errors[0], abs=1e-4)
    assert np.abs(errors[1]).max() < 2e-3
