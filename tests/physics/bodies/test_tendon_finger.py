"""A finger of three rigid links on hinges, with a flexor and an extensor on springs, against its own energy.

Of the angles θ of the hinges alone: weights at the middles of the links, and springs as long as the tendons'
polylines are. Nothing but the tendons holds the links.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation
from support.robots.bodies import CABLE
from support.robots.joined import joined

from tauten.model import Robot, Simulator
from tauten.model.numerics import Array

LINKS, SIDE, ROOT = (0.05, 0.04, 0.03), 0.01, 0.02  # m
MIDDLE, GRAVITY = 0.5 * SIDE, np.array([0.0, 0.0, -9.81])
STIFFNESS, PRETENSION = np.array([300.0, 200.0]), 1.0  # N/m, N
STARTS = ROOT + np.cumsum([0.0, *LINKS[:-1]])  # of the links along x [m]


def tendon(z: float) -> Array:
    """Points of a tendon at rest, two on each link: (7, 3) [m]."""
    along = [
        0.015,
        *(x + s * length for x, length in zip(STARTS, LINKS, strict=True) for s in (0.2, 0.8)),
    ]
    return np.array([[x, MIDDLE, z] for x in along])


TENDONS = tendon(0.001), tendon(0.009)


def finger() -> Robot:
    """The robot."""
    boxes = {"base": ((ROOT, SIDE, SIDE), (1, 1, 1))}
    bodies: list[dict[str, object]] = [{"name": "base", "fixed": [{"kind": "all"}]}]
    hinges, before = [], "base"
    for number, (x, length) in enumerate(zip(STARTS, LINKS, strict=True)):
        name = f"link{number}"
        boxes[name] = ((length, SIDE, SIDE), (2, 1, 1))
        bodies.append({"name": name, "rigid": True, "position": [x, 0.0, 0.0]})
        hinges.append({
            "kind": "hinge", "region": {"kind": "all", "body": name}, "to": {"kind": "all", "body": before},
            "axis": [0.0, 1.0, 0.0], "through": [x, MIDDLE, MIDDLE],
        })  # fmt: skip
        before = name
    cables = [
        {**CABLE, "name": name, "points": points.tolist(), "min_pull": -0.02,
         "spring": {"stiffness": stiffness, "pretension": PRETENSION}}
        for name, points, stiffness in zip(("flexor", "extensor"), TENDONS, STIFFNESS, strict=True)
    ]  # fmt: skip
    tip = [{"name": "tip", "point": [ROOT + sum(LINKS), MIDDLE, MIDDLE]}]
    return joined(
        bodies, boxes, gravity=GRAVITY.tolist(), attachments=hinges, cables=cables, effectors=tip
    )


def placed(theta: Array) -> tuple[list[Array], Array, Array]:
    """Tendons, middles of the links (3, 3) and tip where the hinges have angles (3,)."""
    points = [one.copy() for one in TENDONS]
    hinge, middles = np.array([ROOT, MIDDLE, MIDDLE]), []
    for number, angle in enumerate(np.cumsum(theta)):
        turn, start = Rotation.from_rotvec([0.0, angle, 0.0]), [STARTS[number], MIDDLE, MIDDLE]
        own = slice(1 + 2 * number, 3 + 2 * number)
        for moved, rest in zip(points, TENDONS, strict=True):
            moved[own] = hinge + turn.apply(rest[own] - start)
        middles.append(hinge + turn.apply([0.5 * LINKS[number], 0.0, 0.0]))
        hinge = hinge + turn.apply([LINKS[number], 0.0, 0.0])
    return points, np.array(middles), hinge


def tensions(points: list[Array], pull: Array) -> Array:
    """Tensions (2,) of tendons that winches have pulled [N]."""
    lengths = [np.linalg.norm(np.diff(one, axis=0), axis=1).sum() for one in (*points, *TENDONS)]
    stretch = pull + np.array(lengths[:2]) - lengths[2:]
    return np.maximum(PRETENSION + STIFFNESS * stretch, 0.0)


def energy(theta: Array, pull: Array) -> float:
    """Of springs and weights [J]."""
    points, middles, _ = placed(theta)
    weights = 1000.0 * SIDE**2 * np.outer(LINKS, GRAVITY)  # N
    return float((0.5 * tensions(points, pull) ** 2 / STIFFNESS).sum() - (weights * middles).sum())


def test_it_settles_in_minima_of_its_energy() -> None:
    """From the last one each; at given tensions the links have a negative stiffness."""
    simulator, steps, rng = (
        Simulator(finger(), contact="none"),
        1e-4 * np.eye(3),
        np.random.default_rng(0),
    )
    for _ in range(4):
        pull = rng.uniform(-0.006, 0.012, 2)
        assert simulator.settle(position=pull).converged
        w, _, y, _ = simulator.state.q.reshape(-1, 4).T
        theta = np.diff(2.0 * np.arctan2(y, w), prepend=0.0)
        points, _, tip = placed(theta)
        np.testing.assert_allclose(simulator.effector[0], tip, atol=1e-9)
        np.testing.assert_allclose(simulator.effort, tensions(points, pull), atol=1e-5)
        torques = [(energy(theta + s, pull) - energy(theta - s, pull)) / 2e-4 for s in steps]
        assert np.abs(torques).max() < 1e-6  # N m; the first link weighs 1.2e-3 N m about its hinge
        stiffness = [
            [sum(i * j * energy(theta + 10.0 * (i * a + j * b), pull) for i in (1, -1) for j in (1, -1))
             for a in steps] for b in steps
        ]  # fmt: skip
        assert np.linalg.eigvalsh(stiffness)[0] > 0.0
