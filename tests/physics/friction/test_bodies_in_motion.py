"""Rigid and soft bodies on obstacles and on each other, against closed solutions of mechanics."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.robots.blocks import DENSITY, box, free_bodies, moving, touching
from support.robots.bodies import body_inertia

from tauten.model import Robot, Simulator, contact_wrenches
from tauten.model.mesh import TetMesh, oriented

G = 9.81
FLOOR: dict[str, Any] = {
    "name": "floor", "shape": "plane",
    "parameters": {"point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]},
}  # fmt: skip


def world(
    bodies: dict[str, TetMesh], contacts: list[dict[str, Any]], rate: float, rigid: bool = True,
    **changes: Any,
) -> Robot:  # fmt: skip
    """`free_bodies` on the floor, with their weight."""
    world = {"obstacles": [FLOOR], "gravity": [0.0, 0.0, -G], **changes}
    return free_bodies(bodies, contacts, rate, rigid, **world)


@pytest.mark.long
def test_a_block_slips_on_a_turntable_where_friction_no_longer_turns_it() -> None:
    """By hand: at (ω² r)² + (ω̇ r)² = (μ g)²; before it goes round with the table."""
    friction, r, rate, alpha = 0.3, 0.1, 500.0, 20.0
    cube = box((0.01, 0.01, 0.01), (r - 0.005, -0.005, 0.0), cells=1)
    simulator = Simulator(
        world({"cube": cube}, [touching("cube", "floor", friction=friction)], rate), "full"
    )
    slips = np.sqrt(np.sqrt((friction * G) ** 2 - (alpha * r) ** 2) / r)
    time, way = 0.0, 0.0
    while alpha * time < 1.3 * slips:
        turn = [np.cos(0.5 * way), 0.0, 0.0, np.sin(0.5 * way)]
        spin = alpha * (time + 0.5 / rate)
        simulator.place("floor", [0.0] * 3, turn, spin=[0.0, 0.0, spin])
        simulator.move(effort=[0.0])
        time += 1.0 / rate
        way = 0.5 * alpha * time**2
        x, y, _ = simulator.effector[0]
        if alpha * time < 0.98 * slips:
            assert np.hypot(x, y) == pytest.approx(r, rel=2e-3)
            assert np.unwrap([way, np.arctan2(y, x)])[1] == pytest.approx(way, abs=5e-3)
    assert np.hypot(x, y) > 1.005 * r
    assert np.unwrap([way, np.arctan2(y, x)])[1] < way - 5e-3


@pytest.mark.parametrize("upper", [0.3, 0.0])
@pytest.mark.parametrize("lower", [0.2, 0.0])
def test_of_two_blocks_the_upper_one_goes_along_as_far_as_friction_takes_it(
    upper: float, lower: float
) -> None:
    """By hand, for a push that friction of 0.3 between the blocks could pass on, and for one beyond it."""
    below, above = (0.06, 0.04, 0.01), (0.02, 0.02, 0.02)
    bodies = {
        "below": box(below, (0.0, -0.01, 0.0), 1),
        "above": box(above, (0.018, 1e-4, 0.01001), 1),
    }
    contacts = [
        touching("below", "floor", friction=lower),
        touching("above", "below", friction=upper),
    ]
    masses = DENSITY * np.prod(below), DENSITY * np.prod(above)
    rate, weight = 200.0, sum(masses) * G
    for push in (0.4 * weight, weight):
        simulator = Simulator(world(bodies, contacts, rate), "full")
        for _ in range(5):
            simulator.move(effort=[0.0])
        simulator.move(effort=[push])  # the push grows within this period
        before = simulator.state.v.copy()
        for _ in range(5):
            assert simulator.move(effort=[push]).converged
        found = (simulator.state.v - before)[[0, 6]] * rate / 5.0
        together = (push - lower * weight) / sum(masses)
        slid = (push - lower * weight - upper * masses[1] * G) / masses[0]
        sticks = together < upper * G
        expected = [together, together] if sticks else [slid, upper * G]
        np.testing.assert_allclose(found, expected, rtol=5e-3, atol=1e-6)
        (floor,) = contact_wrenches(simulator.robot, simulator.contacts)
        np.testing.assert_allclose(floor[:3], [lower * weight, 0.0, -weight], rtol=1e-3, atol=1e-5)


@pytest.mark.long
def test_a_top_whose_tip_friction_holds_precesses_as_it_should() -> None:
    """Steady precession Ω: I₃ ω₃ Ω − I₁ Ω² cos θ = m g d, with ω₃ the spin about the axis of the top."""
    sides, radius, tilt, spin, rate = 12, 0.02, np.deg2rad(20.0), 300.0, 2000.0
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.0 * angle + 0.02], axis=1)
    c, s = np.cos(tilt), np.sin(tilt)
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    nodes = np.vstack([ring, np.zeros(3), [0.0, 0.0, 0.02]]) @ turn.T
    tets = oriented(nodes, np.array([[sides, i, (i + 1) % sides, sides + 1] for i in range(sides)]))
    mesh = TetMesh(nodes, tets)
    robot = world({"top": mesh}, [touching("top", "floor", friction=1.0)], rate)
    mass, centre, moments = body_inertia(mesh, DENSITY)
    moments += mass * np.outer(centre, centre)  # about the tip
    tensor = np.trace(moments) * np.eye(3) - moments
    axis = turn[:, 2]
    I_1, I_3 = tensor[1, 1], axis @ tensor @ axis
    moment = mass * G * np.linalg.norm(centre)
    root = np.sqrt((I_3 * spin) ** 2 - 4.0 * I_1 * c * moment)
    precession = (I_3 * spin - root) / (2.0 * I_1 * c)
    omega = spin * axis + precession * (np.array([0.0, 0.0, 1.0]) - c * axis)
    simulator = moving(robot, np.concatenate([np.cross(omega, centre), omega]))
    angles = []
    for _ in range(200):
        simulator.move(effort=[0.0])
        x = simulator.robot.motion(simulator.state).x
        away = (x[sides + 1] - x[sides]) / 0.02
        angles.append(np.arctan2(away[1], away[0]))
        assert np.arccos(away[2]) == pytest.approx(tilt, abs=np.deg2rad(0.3))
    found = (angles[-1] - angles[0]) * rate / 199.0
    assert found == pytest.approx(precession, rel=5e-3)


@pytest.mark.long
def test_what_slides_off_a_sphere_leaves_it_where_it_should() -> None:
    """Without friction, from rest at the top: at cos φ = 2/3; with v at the top, at 2/3 + v² / 3 g R."""
    radius, edge, speed, rate = 0.1, 1e-3, 0.6, 500.0
    ball = {
        "name": "ball",
        "shape": "sphere",
        "parameters": {"centre": [0.0] * 3, "radius": radius},
    }
    cube = box((edge, edge, edge), (-0.5 * edge, -0.5 * edge, radius), cells=1)
    robot = world({"cube": cube}, [touching("cube", "ball", friction=0.0)], rate, obstacles=[ball])
    far = radius + 0.5 * edge
    simulator = moving(robot, np.array([speed, 0.0, 0.0, 0.0, speed / far, 0.0]))
    heights = [1.0]
    while np.linalg.norm(simulator.effector[0]) < 1.01 * far:
        simulator.move(effort=[0.0])
        if simulator.contact_forces.any():
            heights.append(simulator.effector[0][2] / far)
    expected = 2.0 / 3.0 + speed**2 / (3.0 * G * far)
    assert heights[-1] == pytest.approx(expected, abs=heights[-2] - heights[-1])  # within a period


@pytest.mark.parametrize("scale", [0.05, 50.0])
def test_bodies_of_a_millimetre_and_of_a_metre_slide_as_those_of_centimetres(scale: float) -> None:
    """Lengths and moduli times s, times √s: the same motion, forces times s³; 2 cm beside 1 mm and 1 m."""
    angle, edge = np.deg2rad(25.0), 0.02 * scale
    ends = []
    for s, size in ((1.0, 0.02), (scale, edge)):
        cube = box((size, size, size), (0.0, 0.0, 0.05 * size), cells=2)
        robot = world(
            {"cube": cube}, [touching("cube", "floor", friction=0.3)], 200.0 / np.sqrt(s), rigid=False,
            gravity=[G * np.sin(angle), 0.0, -G * np.cos(angle)],
            material={"young_modulus": 1e5 * s, "poisson_ratio": 0.3, "density": DENSITY},
            integration={"rayleigh_stiffness": 0.005 * np.sqrt(s)},
            contact={"alarm_distance": 2e-3 * s},
        )  # fmt: skip
        simulator = Simulator(robot, "full")
        start = simulator.effector[0].copy()
        for _ in range(20):
            assert simulator.move(effort=[0.0]).converged
        way = (simulator.effector[0] - start) / s
        ends.append(np.concatenate([way, simulator.contact_forces.sum(axis=0) / s**3]))
    np.testing.assert_allclose(ends[1], ends[0], rtol=1e-4, atol=1e-7)


def test_a_block_between_plates_resists_as_its_stiffness_says() -> None:
    """Without friction E A ε, for an element that is linear along its own axes; friction adds to it."""
    edge, share, forces = 0.02, 0.2, []
    top = {**FLOOR, "name": "top", "position": [0.0, 0.0, edge],
           "parameters": {"point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, -1.0]}}  # fmt: skip
    for friction in (0.0, 1.0):
        contacts = [touching("cube", name, friction=friction) for name in ("floor", "top")]
        cube = {"cube": box((edge, edge, edge), (0.0, 0.0, 0.0), cells=3)}
        robot = world(
            cube, contacts, 100.0, rigid=False, obstacles=[FLOOR, top], gravity=[0.0, 0.0, 0.0],
            integration={"rayleigh_stiffness": 0.02, "rayleigh_mass": 5.0},
        )  # fmt: skip
        simulator = Simulator(robot, "full")
        simulator.place("top", [0.0, 0.0, edge], velocity=[0.0, 0.0, -5.0 * share * edge])
        for _ in range(20):
            simulator.move(effort=[0.0])
        simulator.place("top", [0.0, 0.0, (1.0 - share) * edge])
        for _ in range(20):
            simulator.move(effort=[0.0])
        found = simulator.contacts
        forces.append([found.force[found.contacts.pair == pair, 2].sum() for pair in (0, 1)])
    expected = 1e5 * edge**2 * share
    np.testing.assert_allclose(forces[0], [expected, -expected], rtol=1e-5)
    assert forces[1][0] == pytest.approx(-forces[1][1], rel=1e-5)
    assert 1.05 * expected < forces[1][0] < 1.2 * expected  # a short block that may not widen


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_groove_carries_a_block_on_its_edge_in_steps_and_at_equilibrium(friction: float) -> None:
    """Weight against the sum of the forces where normals jump: an equilibrium has those of its last step."""
    edge, heights = 0.01, np.abs(np.linspace(-0.05, 0.05, 41))
    groove = {
        "name": "groove", "shape": "height-field",
        "parameters": {"corner": [-0.05, -0.05, 0.0], "spacing": [0.0025, 0.0025], "thickness": 0.02,
                       "heights": [[float(z)] * 41 for z in heights]},
    }  # fmt: skip
    mesh, half = box((edge, edge, edge), (0.0, 0.0, 0.0), cells=2), 0.5**0.5
    turn = np.array([[half, 0.0, half], [0.0, 1.0, 0.0], [-half, 0.0, half]])
    nodes = mesh.nodes @ turn.T
    lowest = nodes[nodes[:, 2].argmin()]
    cube = TetMesh(nodes - [lowest[0], 0.0, lowest[2] - 1e-4], mesh.tets)
    contact = touching("cube", "groove", friction=friction)
    simulator = Simulator(world({"cube": cube}, [contact], 200.0, obstacles=[groove]), "full")
    for _ in range(20):
        simulator.move(effort=[0.0])
    weight = DENSITY * edge**3 * G
    carried = [0.0, 0.0, weight]
    np.testing.assert_allclose(simulator.contact_forces.sum(axis=0), carried, atol=1e-5 * weight)
    simulator.start_from(simulator.state)
    for _ in range(2):
        assert simulator.settle(effort=[0.0]).converged
        force = simulator.contact_forces.sum(axis=0)
        np.testing.assert_allclose(force, carried, atol=1e-5 * weight)
        certificate = simulator.certificate
        assert (certificate is not None) == (friction > 0.0)
        assert certificate is None or certificate.error < 1e-8
