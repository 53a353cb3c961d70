"""Rigid bodies that slide, spin, tip and strike, against rigid-body mechanics solved by hand or by scipy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.robots.blocks import DENSITY, box, free_bodies, moving, plane, touching
from support.robots.bodies import body_inertia
from support.robots.joined import joined

from tauten.model import Robot, Simulator
from tauten.model.mesh import TetMesh, oriented
from tauten.model.numerics import Array

G = 9.81
FLOOR = plane("floor", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))


def on_floor(mesh: TetMesh, friction: float, rate: float, **changes: Any) -> Robot:
    """One rigid body whose vertices touch a floor, with its weight."""
    world = {"obstacles": [FLOOR], "gravity": [0.0, 0.0, -G], **changes}
    contacts = world.pop("contacts", [touching("body", "floor", friction=friction)])
    return free_bodies({"body": mesh}, contacts, rate, **world)


def tripod() -> TetMesh:
    """A tetrahedron on three vertices, whose normal forces statics alone determine."""
    angle, radius = np.array([0.3, 2.2, 4.6]), np.array([0.02, 0.025, 0.018])
    feet = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.0 * angle], axis=1)
    nodes = np.vstack([feet, [0.012, 0.006, 0.02]])
    return TetMesh(nodes, oriented(nodes, np.array([[0, 1, 2, 3]])))


def sliding_tripod(mesh: TetMesh, friction: float, start: Array, seconds: float) -> Array:
    """Where a tripod that slides and spins is after a time, by Newton and Euler: its way (2,) and angle (3,).

    Of each foot the friction is against its velocity; its normal force follows from the balances of forces
    along z and of moments, in which it moves neither up nor about x or y.
    """
    mass, centre, moments = body_inertia(mesh, DENSITY)
    inertia = np.trace(moments) * np.eye(3) - moments

    def rate(_: float, y: Array) -> Array:
        c, s = np.cos(y[2]), np.sin(y[2])
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        feet, turned = (mesh.nodes[:3] - centre) @ turn.T, turn @ inertia @ turn.T
        omega = np.array([0.0, 0.0, y[5]])
        v = np.array([y[3], y[4], 0.0]) + np.cross(omega, feet)  # (3, 3) of the feet
        force = -friction * v / np.linalg.norm(v, axis=1)[:, None] + [0.0, 0.0, 1.0]
        balance = np.zeros((4, 4))  # of normal forces and the angular acceleration
        balance[0, :3], balance[1:, :3] = 1.0, np.cross(feet, force).T
        balance[1:, 3] = -turned[:, 2]
        known = np.concatenate([[mass * G], np.cross(omega, turned @ omega)])
        *normal, spin = np.linalg.solve(balance, known)
        return np.concatenate([y[3:], force[:, :2].T @ normal / mass, [spin]])

    path = solve_ivp(rate, (0.0, seconds), np.concatenate([np.zeros(3), start]), rtol=1e-8)
    end: Array = path.y[:3, -1]
    return end


@pytest.mark.long
def test_a_tripod_that_slides_and_spins_moves_as_newton_and_euler_say() -> None:
    friction, rate, ticks, mesh = 0.3, 100.0, 10, tripod()
    start = np.array([0.4, 0.1, 20.0])  # m/s, rad/s; it stops after 0.12 s
    simulator = moving(on_floor(mesh, friction, rate), np.array([0.4, 0.1, 0.0, 0.0, 0.0, 20.0]))
    before, feet = simulator.effector[0], mesh.nodes[1] - mesh.nodes[0]
    for _ in range(ticks):
        assert simulator.move(effort=[0.0]).converged
    expected = sliding_tripod(mesh, friction, start, ticks / rate)
    way = simulator.effector[0] - before
    np.testing.assert_allclose(way, [*expected[:2], 0.0], atol=1e-3 * np.linalg.norm(expected[:2]))
    x = simulator.robot.points(simulator.state)
    c, s = np.cos(expected[2]), np.sin(expected[2])
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ feet
    np.testing.assert_allclose(x[1] - x[0], turned, atol=1e-3 * np.linalg.norm(feet))


@pytest.mark.parametrize(
    ("push", "height", "tips"),
    [(0.45, 0.02, False), (0.45, 0.03, True), (0.7, 0.02, False), (0.7, 0.035, True)],
)
def test_a_box_that_is_pushed_high_tips_about_its_edge(
    push: float, height: float, tips: bool
) -> None:
    """By hand: it slides where the push is beyond μ m g, and tips where it is beyond m g a / 2 z."""
    a, tall, friction, rate = 0.02, 0.04, 0.5, 500.0
    mesh = box((a, a, tall), (-a, -0.5 * a, 0.0), cells=1)
    force = {
        "name": "push", "point": [-a, 0.0, height], "direction": [1.0, 0.0, 0.0], "max_force": 10.0,
        "max_travel": 1e3, "max_rate": 1e3, "max_outside": 1e-3,
    }  # fmt: skip
    simulator = Simulator(on_floor(mesh, friction, rate, forces=[force]))
    mass, _, moments = body_inertia(mesh, DENSITY)
    weight = mass * G
    for effort in (0.0, push * weight):  # it grows in the second period
        simulator.move(effort=[effort])
    before = simulator.state.v.copy()
    assert simulator.move(effort=[push * weight]).converged
    found = (simulator.state.v - before)[[0, 2, 4]] * rate
    slides = max(push - friction, 0.0) * G
    about_edge = moments[0, 0] + moments[2, 2] + 0.25 * mass * (a**2 + tall**2)
    turns = weight * (push * height - 0.5 * a) / about_edge
    expected = turns * np.array([0.5 * tall, 0.5 * a, 1.0]) if tips else [slides, 0.0, 0.0]
    np.testing.assert_allclose(found, expected, rtol=5e-3, atol=1e-4)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_box_on_two_floors_is_braked_by_what_each_of_them_carries(way: float) -> None:
    """By hand: friction at the bottom moves the weight to the front, where μ is ½ or 0.1."""
    length, tall, rate = 0.06, 0.02, 500.0
    mesh = box((length, 0.02, tall), (0.0, -0.01, 0.0), cells=1)
    sides = {"left": (-0.3, 0.03, 0.1), "right": (0.03, 0.3, 0.5)}
    floors = [
        {"name": name, "shape": "box",
         "parameters": {"lower": [low, -0.1, -0.05], "upper": [high, 0.1, 0.0]}}
        for name, (low, high, _) in sides.items()
    ]  # fmt: skip
    contacts = [touching("body", name, friction=mu) for name, (*_, mu) in sides.items()]
    robot = on_floor(mesh, 0.0, rate, obstacles=floors, contacts=contacts)
    simulator = moving(robot, np.array([0.5 * way, 0.0, 0.0, 0.0, 0.0, 0.0]))
    for _ in range(10):
        assert simulator.move(effort=[0.0]).converged
    mu, lever = np.array([0.1, 0.5]), way * tall / length
    shares = np.linalg.solve([[1.0, 1.0], np.array([-1.0, 1.0]) - lever * mu], [1.0, 0.0])
    braked = 0.5 - way * simulator.state.v[0]
    assert braked == pytest.approx(mu @ shares * G * 10.0 / rate, rel=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_links_that_strike_a_floor_have_the_velocity_of_an_inelastic_impact(
    friction: float,
) -> None:
    """The impulse goes through a hinge: by hand, at the corner of the second link that strikes.

    With rates ω of both angles θ, mass matrix M and rows J of the corner's velocity along z and x: J ω = 0
    along z, and along x a friction of μ times the impulse, against the motion.
    """
    size, lengths, root, rate = 0.01, (0.05, 0.04), 0.02, 2000.0
    middle, boxes = 0.5 * size, {"base": ((root, size, size), (1, 1, 1))}
    bodies: list[dict[str, object]] = [{"name": "base", "fixed": [{"kind": "all"}]}]
    hinges, x, before = [], root, "base"
    for name, length in zip(("first", "second"), lengths, strict=True):
        boxes[name] = ((length, size, size), (2, 1, 1))
        bodies.append({"name": name, "rigid": True, "position": [x, 0.0, 0.0]})
        hinges.append({
            "kind": "hinge", "region": {"kind": "all", "body": name}, "to": {"kind": "all", "body": before},
            "axis": [0.0, 1.0, 0.0], "through": [x, middle, middle],
        })  # fmt: skip
        x, before = x + length, name
    simulator = Simulator(joined(
        bodies, boxes, gravity=[0.0, 0.0, -G], attachments=hinges,
        effectors=[{"name": "tip", "point": [x, middle, 0.0]}], controller={"rate": rate},
        integration={"scheme": "implicit-euler"}, contact={"alarm_distance": 5e-3},
        regions=[{"name": "second", "kind": "skin", "body": "second"}],
        obstacles=[plane("floor", (0.0, 0.0, -0.01), (0.0, 0.0, 1.0))],
        contacts=[touching("second", "floor", friction=friction)],
    ))  # fmt: skip
    rates = [np.zeros(2), np.zeros(2)]
    while not simulator.contact_forces.any():
        simulator.move(effort=[0.0])
        rates.append(simulator.state.v[[1, 4]])
    omega = 2.0 * rates[-2] - rates[-3]  # without the impact
    x_all = simulator.robot.points(simulator.state)
    edges = x_all[[16, 28]] - x_all[[8, 20]]  # along the two links, of 12 nodes each
    c, s = np.cos(angle := np.arctan2(-edges[:, 2], edges[:, 0])), np.sin(angle)
    mass = DENSITY * size**2 * np.array(lengths)
    M = np.diag(mass * (np.array(lengths) ** 2 / 3.0 + size**2 / 12.0))
    M[0, 0] += mass[1] * lengths[0] ** 2
    M[0, 1] = M[1, 0] = 0.5 * mass[1] * lengths[0] * lengths[1] * np.cos(angle[0] - angle[1])
    corner = np.array([  # the upper end of the second link is lower than its tip
        [-lengths[0] * c[0], middle * s[1]], [-lengths[0] * s[0], -middle * c[1]],
    ])  # fmt: skip
    W, u = corner @ np.linalg.solve(M, corner.T), corner @ omega
    sliding = -np.sign(u[1]) * friction
    normal = -u[0] / (W[0, 0] + sliding * W[0, 1])
    expected = omega + np.linalg.solve(M, corner.T @ (normal * np.array([1.0, sliding])))
    np.testing.assert_allclose(rates[-1], expected, rtol=0.01, atol=0.01 * abs(omega[0]))
