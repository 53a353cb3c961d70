"""A soft sphere pressed on a plate, against Hertz, with and without friction."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from support.robots.bodies import beam_config, box_mesh

from tauten.model import Simulator
from tauten.model.load import build_robot
from tauten.model.mesh import TetMesh, checked
from tauten.model.schema import RobotConfig

RADIUS, APPROACH = 0.01, 6.4e-5  # m
YOUNG, POISSON = 1e5, 0.3
CONTACT = np.sqrt(RADIUS * APPROACH)  # radius of the contact a, Hertz
FORCE = 4.0 / 3.0 * YOUNG / (1.0 - POISSON**2) * np.sqrt(RADIUS * APPROACH**3)  # N
FINE, ACROSS, UP = CONTACT / 5.0, 7, 6


def graded(cells: int, length: float) -> np.ndarray:
    """Coordinates from 0 to a length whose first step is FINE, each longer than the one before."""
    ratio = brentq(lambda r: FINE * (r**cells - 1.0) / (r - 1.0) - length, 1.0 + 1e-6, 10.0)
    return FINE * (ratio ** np.arange(cells + 1) - 1.0) / (ratio - 1.0)


def column() -> TetMesh:
    """A square column of a sphere whose pole is at the origin, up to its middle, fine about the pole."""
    unit = box_mesh((2.0, 2.0, 1.0), (2 * ACROSS, 2 * ACROSS, UP))
    steps = np.rint((unit.nodes - [1.0, 1.0, 0.0]) * [ACROSS, ACROSS, UP]).astype(int)
    flat = np.sign(steps[:, :2]) * graded(ACROSS, 0.5 * RADIUS)[np.abs(steps[:, :2])]
    up = graded(UP, RADIUS)[steps[:, 2]] / RADIUS
    low = RADIUS - np.sqrt(RADIUS**2 - (flat**2).sum(axis=1))
    return checked(np.column_stack([flat, low + up * (RADIUS - low)]), unit.tets, "column")


def pressed(friction: float) -> Simulator:
    """The column, whose upper side is held, on a plate that is higher than its pole by the approach."""
    settings = beam_config(
        (RADIUS, RADIUS, RADIUS),
        material={"young_modulus": YOUNG, "poisson_ratio": POISSON, "density": 1000.0},
        mesh={"file": "sphere.vtu", "element": "smoothed"},
        integration={"scheme": "quasi-static"},
        fixed=[{"lower": [-1.0, -1.0, RADIUS - 1e-6], "upper": [1.0, 1.0, 1.0]}],
        cables=[], forces=[{"name": "none", "point": [0.0, 0.0, 0.5 * RADIUS],
            "direction": [0.0, 0.0, 1.0], "max_force": 1.0, "max_travel": 0.01, "max_rate": 1.0}],
        effectors=[{"name": "pole", "point": [0.0, 0.0, 0.5 * RADIUS]}],
        obstacles=[{"name": "plate", "shape": "plane", "parameters": {
            "point": [0.0, 0.0, APPROACH], "normal": [0.0, 0.0, 1.0]}}],
        regions=[{"name": "below", "kind": "normal", "direction": [0.0, 0.0, -1.0], "max_angle_deg": 15.0}],
        contacts=[{"candidates": "below", "against": "plate", "points": "vertices", "friction": friction}],
        contact={"alarm_distance": 1e-3, "tolerance": 1e-4},
    )  # fmt: skip
    robot = build_robot(RobotConfig.model_validate(settings), column(), "sphere")
    simulator = Simulator(robot)
    assert simulator.settle(effort=[0.0]).converged
    return simulator


@pytest.mark.long
def test_force_and_radius_of_a_contact_are_those_of_hertz_and_friction_adds_to_the_force() -> None:
    """F = 4/3 E* √(R d³) and a = √(R d) within 5 %; the radius from Σ f r² = 2/5 a² Σ f.

    Where nothing slips friction makes a punch stiffer by (1 − ν) ln(3 − 4ν) / (1 − 2ν) = 1.029
    (Mossakovskii, Journal of Applied Mathematics and Mechanics 27, 1963); here the rim slips.
    """
    force, radius = {}, {}
    for friction in (0.0, 0.5):
        simulator = pressed(friction)
        contacts = simulator.contacts
        f, x = contacts.normal_force, simulator.robot.candidates(simulator.state)
        r = np.linalg.norm(x[contacts.contacts.slots, :2], axis=1)  # (m,) m
        force[friction], radius[friction] = f.sum(), np.sqrt(2.5 * (f @ r**2) / f.sum())
        assert radius[friction] == pytest.approx(CONTACT, rel=0.05)
    assert force[0.0] == pytest.approx(FORCE, rel=0.05)
    assert force[0.5] / force[0.0] == pytest.approx(1.029, abs=0.01)
    stuck = contacts.margin > 0.0
    assert 0.0 < r[stuck].max() < r[contacts.pushing].max()
