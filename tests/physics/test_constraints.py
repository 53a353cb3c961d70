"""Rigid bodies, drives, hinges and glue against rigid-body mechanics, beam theory and one mesh."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from support.robots.bodies import CABLE, beam_robot, box_mesh
from support.robots.joined import joined
from support.robots.small_bodies import ROOT, RUBBER, SIZE, constrained, moved, rigid_box

from tauten.model import Robot, Simulator, State
from tauten.model.constraints import ConstrainedBody
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array

G = 9.81
STILL = {"max_angle": 7.0, "max_torque": 100.0, "max_rate": 100.0}


FLAT = (0.1, 0.04, 0.02)


def box_inertia(size: tuple[float, float, float]) -> Array:
    """Moments of inertia of a box of rubber about its axes: (3,) [kg m²]."""
    squares = np.array(size) ** 2
    moments: Array = 1000.0 * np.prod(size) * (squares.sum() - squares) / 12.0
    return moments


def spinning(robot: Robot[ConstrainedBody], omega: Array) -> State:
    """At rest in place, turning with omega (3,) [rad/s]."""
    rest = robot.rest()
    return State(rest.q, np.concatenate([np.zeros(3), omega]))


def stepped(robot: Robot[ConstrainedBody], state: State, steps: int) -> list[State]:
    """States of steps without actuators."""
    states = [state]
    for _ in range(steps):
        system = robot.linearise(states[-1])
        states.append(robot.advance(states[-1], system.v_free, system.h))
    return states


def test_a_rigid_body_falls_freely() -> None:
    robot = rigid_box(gravity=[0.0, 0.0, -G], controller={"rate": 100.0})
    assert robot.n == 6
    states = stepped(robot, robot.rest(), 50)
    h, t = 0.01, 0.5
    fallen = robot.body.nodes(states[-1]) - robot.body.mesh.nodes
    assert fallen[:, :2] == pytest.approx(0.0, abs=1e-12)
    assert fallen[:, 2] == pytest.approx(-0.5 * G * t * (t + h))  # implicit Euler's sum


def test_a_rigid_body_turns_uniformly_about_a_principal_axis() -> None:
    robot = rigid_box(controller={"rate": 100.0})
    for axis in np.eye(3):
        omega = 3.0 * axis
        last = stepped(robot, spinning(robot, omega), 100)[-1]
        assert last.v == pytest.approx(np.concatenate([np.zeros(3), omega]), abs=1e-9)
        centre = 0.5 * np.array(SIZE)
        turned = Rotation.from_rotvec(omega).apply(robot.body.mesh.nodes - centre) + centre
        assert np.abs(robot.body.nodes(last) - turned).max() < 1e-9


@pytest.mark.parametrize("element", ["linear", "smoothed", "quadratic"])
@pytest.mark.parametrize("total", [None, 0.3])
def test_the_inertia_of_a_rigid_box_does_not_depend_on_its_mesh(
    element: str, total: float | None
) -> None:
    """In any pose; the gyroscopic moment is −ω x I ω."""
    material = RUBBER if total is None else {**RUBBER, "total_mass": total}
    body = {"name": "box", "mesh": {"file": "box.vtu", "element": element}, "rigid": True}
    robot = constrained(
        [box_mesh(FLAT, (2, 1, 1))], mesh=None, fixed=[], bodies=[{**body, "free": True}],
        material=material,
    )  # fmt: skip
    turn = Rotation.from_rotvec([0.3, 0.8, -0.4])
    expected = box_inertia(FLAT) * (1.0 if total is None else total / (1000.0 * np.prod(FLAT)))
    R, omega = turn.as_matrix(), np.array([1.0, 2.0, 3.0])
    I_R = R @ np.diag(expected) @ R.T
    q = np.concatenate([robot.rest().q[:3], turn.as_quat()[[3, 0, 1, 2]]])
    state = State(q, np.concatenate([np.zeros(3), omega]))
    M = robot.body.matrix(robot.body.masses(state)).toarray()
    np.testing.assert_allclose(M[3:, 3:], I_R, atol=1e-12 * expected.max())
    gyroscopic = robot.body.inertia_at(state)
    assert gyroscopic is not None
    moment = -np.cross(omega, I_R @ omega)
    np.testing.assert_allclose(gyroscopic[3:], moment, atol=1e-12 * np.abs(moment).max())


@pytest.mark.slow
def test_a_tumbling_body_follows_eulers_equations() -> None:
    """Torque-free, about the unstable axis: Euler's equations by a Runge-Kutta method."""
    robot = rigid_box(box_mesh(FLAT, (5, 2, 1)), controller={"rate": 4000.0})
    values, omega = box_inertia(FLAT), np.array([0.1, 4.0, 0.2])

    def rate(_: float, w: Array) -> Array:
        return -np.cross(w, values * w) / values

    path = solve_ivp(rate, (0.0, 1.0), omega, rtol=1e-10, atol=1e-12)
    states = stepped(robot, spinning(robot, omega), 4000)
    last = states[-1]
    T = robot.body.matrix(robot.body.masses(last)).toarray()
    start = robot.body.matrix(robot.body.masses(states[0])).toarray()
    energy = [0.5 * v @ M @ v for v, M in ((states[0].v, start), (last.v, T))]
    assert energy[1] == pytest.approx(energy[0], rel=2e-3)
    momentum = [(M @ v)[3:] for v, M in ((states[0].v, start), (last.v, T))]
    assert momentum[1] == pytest.approx(momentum[0], rel=2e-3, abs=2e-3 * abs(momentum[0]).max())
    turn = Rotation.from_quat(last.q[[4, 5, 6, 3]])
    own = turn.inv().apply(last.v[3:])
    assert own == pytest.approx(path.y[:, -1], abs=2e-2)


def pendulum(**changes: object) -> Robot[ConstrainedBody]:
    """A rigid bar that a servo or a hinge at one end holds."""
    stiff = {**RUBBER, "young_modulus": 1e9}
    return constrained(material=stiff, fixed=[], gravity=[0.0, 0.0, -G], **changes)


def test_a_servo_bears_the_weight_of_a_lever() -> None:
    """The holding torque is the mass times gravity times the horizontal distance of its centre."""
    turn = {"name": "servo", "region": {"kind": "all"}, "axis": [0.0, 1.0, 0.0], **STILL}
    robot = pendulum(drives=[{**turn, "through": [0.0, 0.01, 0.01]}])
    simulator = Simulator(robot, contact="none")
    mass = 1000.0 * np.prod(SIZE)
    for angle in (0.0, 0.5, np.pi / 2, 4.0, -2.0):
        effort = [0.0, np.nan]
        assert simulator.settle(position=[np.nan, angle], effort=effort).converged
        lever = 0.05 * np.cos(angle)
        assert simulator.effort[1] == pytest.approx(-mass * G * lever, rel=1e-6, abs=1e-12)


def test_a_hinge_on_the_frame_swings_with_the_period_of_a_compound_pendulum() -> None:
    hinge = {
        "kind": "hinge", "region": {"kind": "all"},
        "axis": [0.0, 1.0, 0.0], "through": [0.05, 0.01, 0.02],
    }  # fmt: skip
    rate = 2000.0
    robot = pendulum(attachments=[hinge], controller={"rate": rate})
    mass = 1000.0 * np.prod(SIZE)
    period = 2.0 * np.pi * np.sqrt((box_inertia(SIZE)[1] + mass * 0.01**2) / (mass * G * 0.01))
    states = stepped(robot, moved(robot, robot.rest(), np.array([0.02])), 2250)
    angle = np.array([state.q[-1] for state in states])
    crossings = np.flatnonzero((angle[:-1] > 0.0) & (angle[1:] <= 0.0)) / rate
    assert len(crossings) >= 2
    assert np.diff(crossings)[0] == pytest.approx(period, rel=2e-3)


def test_a_servo_at_the_end_of_a_beam_feels_four_e_i_over_l() -> None:
    """A clamped beam whose other end turns about its middle by a small angle: M = 4 E I θ / L."""
    size = (0.3, 0.02, 0.02)
    face = {"lower": [0.3, 0.0, 0.0], "upper": [0.3, 0.02, 0.02]}
    turn = {"name": "servo", "region": face, "axis": [0.0, 1.0, 0.0], **STILL}
    robot = constrained(
        box_mesh(size, (15, 1, 1)), size,
        mesh={"file": "beam.vtu", "element": "quadratic"},
        material={**RUBBER, "poisson_ratio": 0.0},
        drives=[{**turn, "through": [0.3, 0.01, 0.01]}],
    )  # fmt: skip
    simulator = Simulator(robot, contact="none")
    angle = 1e-3
    assert simulator.settle(position=[np.nan, angle], effort=[0.0, np.nan]).converged
    stiffness = 1e6 * 0.02**4 / 12.0
    length, area = 0.3, 0.02**2
    shear = 12.0 * stiffness / (1e6 / 2.0 * 5.0 / 6.0 * area * length**2)  # Timoshenko
    expected = (4.0 + shear) / (1.0 + shear) * stiffness / length * angle
    assert simulator.effort[1] == pytest.approx(expected, rel=1e-2)


def test_a_slider_stretches_a_bar() -> None:
    face = {"lower": [0.1, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]}
    slider = {
        "name": "slider", "motion": "translation", "region": face, "axis": [1.0, 0.0, 0.0],
        "max_travel": 0.01, "max_force": 100.0, "max_rate": 1.0,
    }  # fmt: skip
    robot = constrained(drives=[slider], material={**RUBBER, "poisson_ratio": 0.0})
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(position=[np.nan, 0.001], effort=[0.0, np.nan]).converged
    assert simulator.effort[1] == pytest.approx(1e6 * 0.02**2 * 0.001 / 0.1, rel=1e-6)
    rest, way = robot.rest(), np.zeros(robot.n)
    way[-1] = 2e-3  # of the slider
    gone = robot.body.nodes(moved(robot, rest, way)) - robot.body.nodes(rest)
    assert np.linalg.norm(gone, axis=1).max() == pytest.approx(2e-3)
    assert robot.displacement(rest, way) == pytest.approx(2e-3)


def halves() -> tuple[TetMesh, list[TetMesh]]:
    """A beam of one mesh, and the same tetrahedra as two meshes that meet at x = 0.05."""
    left = box_mesh((0.05, 0.02, 0.02), (4, 2, 2))
    right = TetMesh(left.nodes + np.array([0.05, 0.0, 0.0]), left.tets)
    nodes, inverse = np.unique(
        np.concatenate([left.nodes, right.nodes]).round(12), axis=0, return_inverse=True
    )
    inverse = inverse.ravel()
    tets = np.concatenate([inverse[left.tets], inverse[len(left.nodes) + right.tets]])
    return TetMesh(nodes, tets), [left, right]


def test_a_glued_pair_is_one_mesh() -> None:
    """Static and dynamic, under gravity and a cable through both halves: the same to rounding."""
    whole, parts = halves()
    tables = [
        {"name": "left", "mesh": {"file": "a"}, "fixed": [ROOT]},
        {"name": "right", "mesh": {"file": "b"}},
    ]
    face = {"body": "right", "lower": [0.05, 0.0, 0.0], "upper": [0.05, 0.02, 0.02]}
    glue = {"kind": "glue", "region": face, "to": {"kind": "all", "body": "left"}}
    common = {"gravity": [0.0, 0.0, -G], "material": RUBBER}
    pair = constrained(parts, mesh=None, fixed=[], bodies=tables, attachments=[glue], **common)
    one = beam_robot(whole, SIZE, **common)
    order = np.array(
        [int(np.linalg.norm(whole.nodes - x, axis=1).argmin()) for x in pair.body.mesh.nodes]
    )
    first, second = Simulator(pair, contact="none"), Simulator(one, contact="none")
    for simulator in (first, second):
        assert simulator.settle(position=[0.004], tolerance=1e-11).converged
    assert first.effort == pytest.approx(second.effort, rel=1e-9)
    assert np.abs(pair.body.nodes(first.state) - one.body.nodes(second.state)[order]).max() < 1e-10
    for simulator in (first, second):
        simulator.reset()
        for _ in range(10):
            simulator.step(effort=[0.5])
    assert np.abs(pair.body.nodes(first.state) - one.body.nodes(second.state)[order]).max() < 1e-10


def hinged_plate(radius: float) -> Robot[ConstrainedBody]:
    """A rigid plate beside a soft one, glued within a radius of an edge [m]; nodes are 1 cm apart."""
    plate = {
        "name": "plate", "mesh": {"file": "b"}, "position": [0.1, 0.0, 0.0],
        "material": {**RUBBER, "young_modulus": 1e9},
    }  # fmt: skip
    soft = {"name": "soft", "mesh": {"file": "a"}, "fixed": [ROOT, {"kind": "all"}]}
    soft["fixed"] = [{"lower": [0.0, 0.0, 0.0], "upper": [0.09, 0.02, 0.02]}]
    hinge = {
        "kind": "hinge", "region": {"kind": "all", "body": "plate"}, "to": {"kind": "all", "body": "soft"},
        "axis": [0.0, 1.0, 0.0], "through": [0.1, 0.0, 0.02], "radius": radius, "max_distance": 0.05,
    }  # fmt: skip
    mesh = box_mesh(SIZE, (10, 2, 2))
    return constrained(
        [mesh, mesh], mesh=None, fixed=[], bodies=[soft, plate], attachments=[hinge],
        gravity=[0.0, 0.0, -G], material={**RUBBER, "young_modulus": 1e9},
        integration={"rayleigh_mass": 20.0},
    )  # fmt: skip


def test_a_hinge_ties_what_lies_within_its_radius() -> None:
    """Three nodes on the axis; with a little more than 1 cm those beside and below it, three each, too."""
    assert hinged_plate(1e-6).n - hinged_plate(0.0101).n == 3 * 6


def test_two_bodies_hinged_along_an_edge_turn_freely_about_it() -> None:
    """A rigid plate hangs from a soft one: glued along a line it hangs straight down."""
    robot = hinged_plate(1e-6)
    simulator = Simulator(robot, contact="none")
    for _ in range(400):
        simulator.step(effort=[0.0])
    x = robot.body.nodes(simulator.state)[robot.n_nodes // 2 :]
    centre = x.mean(axis=0)
    assert abs(centre[0] - 0.1) < 2e-3
    assert centre[2] == pytest.approx(0.02 - np.hypot(0.05, 0.01), abs=1e-3)


def test_a_rigid_region_keeps_its_shape_while_the_rest_bends() -> None:
    end = {"kind": "half_space", "point": [0.0749, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}
    robot = constrained(rigid=[{"name": "tip", "region": end}])
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(position=[0.006]).converged
    x, x0 = robot.body.nodes(simulator.state), robot.body.mesh.nodes
    kept = x0[:, 0] > 0.0749
    between = np.linalg.norm(x[kept][:, None] - x[kept], axis=2)
    assert np.allclose(between, np.linalg.norm(x0[kept][:, None] - x0[kept], axis=2), atol=1e-12)
    assert np.linalg.norm(x[kept] - x0[kept], axis=1).max() > 5e-3


def test_a_drive_is_drawn_on_its_axis_beside_its_region() -> None:
    """The axis lies through another place: the point that is drawn has the height of the region on it."""
    servo = {
        "name": "servo", "region": {"lower": [0.08, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]},
        "axis": [0.0, 2.0, 0.0], "through": [0.07, 0.5, 0.03], **STILL,
    }  # fmt: skip
    robot = constrained(drives=[servo])
    start, end = robot.body.actuator_set.drives.segments(np.zeros(1))[0]
    nodes = robot.body.mesh.nodes
    beside = nodes[nodes[:, 0] > 0.0799, 1].mean()
    assert start == pytest.approx([0.07, beside, 0.03])
    assert end - start == pytest.approx([0.0, 1.0, 0.0])


@pytest.mark.parametrize(("points", "up", "angles"), [
    ([[0.05, 0.01, 0.002], [0.15, 0.01, 0.002]], -1.0, (0.4, 0.6, 0.75)),
    ([[0.08, 0.01, 0.0], [0.12, 0.01, 0.0]], 1.0, (0.0, -0.3, -0.6, -0.2)),
])  # fmt: skip
def test_a_link_that_its_tendon_alone_holds_is_at_rest(
    points: list[list[float]], up: float, angles: tuple[float, ...]
) -> None:
    """An arm that hangs, and one that stands on its head and leans on its tendon: m g sin θ times the levers.

    At a given tension the link has a negative stiffness, and no search found these equilibria reliably.
    """
    bar, lean = ((0.1, 0.02, 0.02), (2, 1, 1)), 0.3 if up > 0.0 else 0.0
    whole = {name: {"kind": "all", "body": name} for name in ("upper", "lower")}
    axis = {"axis": [0.0, 1.0, 0.0]}
    robot = joined(
        [{"name": "upper"}, {"name": "lower", "rigid": True, "position": [0.1, 0.0, 0.0]}],
        {"upper": bar, "lower": bar},
        gravity=[-up * G * np.cos(lean), 0.0, G * np.sin(lean)],
        drives=[{"name": "shoulder", "region": whole["upper"], "through": [0, 0.01, 0.01], **axis, **STILL}],
        attachments=[{"kind": "hinge", "region": whole["lower"], "to": whole["upper"],
                      "through": [0.1, 0.01, 0.01], **axis}],
        cables=[{**CABLE, "points": points}],
        effectors=[{"name": "tip", "point": [0.2, 0.01, 0.01]}],
    )  # fmt: skip
    simulator, weight = Simulator(robot, contact="none"), 1000.0 * 0.1 * 0.02**2 * G  # N
    for angle in angles:
        assert simulator.settle(position=[0.0, angle]).converged
        straight = [0.2 * np.cos(angle), 0.01, 0.01 - 0.2 * np.sin(angle)]
        assert simulator.effector[0] == pytest.approx(straight, abs=1e-6)
        across = weight * abs(np.sin(angle - lean))  # N
        lever = 0.01 - points[0][2]  # of the tendon about the hinge [m]
        assert simulator.effort == pytest.approx([0.05 * across / lever, 0.2 * across], rel=1e-4)
