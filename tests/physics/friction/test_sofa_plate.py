"""The finger of SoftRobots pressed on a plate with and without friction, on the curves of SOFA."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.sofa_fingers import finger_cable
from support.robots.sofa_robots import robots_folder
from support.sofa.elements import MM, points_as_in_sofa

from tauten.model import Robot, Simulator
from tauten.model.load import build_robot
from tauten.model.mesh import checked
from tauten.model.schema import RobotConfig

SETTLED = 1e-6  # mm; rows of SOFA that moved more in their last step are no equilibria


@pytest.fixture(scope="module")
def data(reference: Path) -> Path:
    return robots_folder(reference, "plate_mu05_fpolar.csv")


def finger(data: Path, friction: float) -> Robot:
    """The finger below a plate y = 40 mm that holds it 1 mm off; all nodes of its surface may touch."""
    model = np.load(data / "finger_plate_model.npz")
    config = RobotConfig.model_validate(
        {
            "name": "finger",
            "gravity": [0.0, 0.0, 0.0],
            "mesh": {"file": "finger.npz"},
            "material": {"young_modulus": 6e5, "poisson_ratio": 0.45, "density": 1000.0},
            "fixed": [{"kind": "nodes", "numbers": model["fixed"].tolist()}],
            "cables": [finger_cable(model)],
            "effectors": [
                {"name": "tip", "point": (MM * model["tip"][0]).tolist(), "max_outside": 5e-3}
            ],
            "obstacles": [
                {"name": "plate", "shape": "plane",
                 "parameters": {"point": [0.0, 0.04, 0.0], "normal": [0.0, -1.0, 0.0]}}
            ],
            "contacts": [{"against": "plate", "points": "vertices", "friction": friction}],
            "contact": {"distance": 1e-3, "alarm_distance": 4e-3},
        }
    )  # fmt: skip
    nodes = MM * model["nodes"]
    return build_robot(config, checked(nodes, model["tets"].astype(np.int64), "finger"), "finger")


@pytest.mark.parametrize(
    ("friction", "until", "across"), [(0.0, 16.0, 1e-4), (0.5, 20.0, 0.1)], ids=["without", "with"]
)
def test_the_finger_presses_on_the_plate_as_in_sofa(
    data: Path, friction: float, until: float, across: float
) -> None:
    """Tip [mm], tension and force on the plate [mN] at every half millimetre of cable from 13.5 mm on.

    With friction each state follows from the one before. SOFA comes to each in some time steps, we in some
    quasi-static ones; what differs is how far the finger has slid in z, where nothing but friction acts.
    """
    file = "plate_mu05_fpolar.csv" if friction else "plate_mu0_fpolar.csv"
    curve = np.genfromtxt(data / file, delimiter=",", names=True)
    curve = curve[(curve["imposed"] >= 13.5) & (curve["imposed"] <= until)]
    assert (curve["last_max_dx"] < SETTLED).all() and (curve["F_y"] < -50.0).any()
    with points_as_in_sofa(np.load(data / "finger_plate_model.npz"), "cable", "tip"):
        simulator = Simulator(finger(data, friction))
    for row in curve:
        assert simulator.settle(position=[MM * row["imposed"]], tolerance=1e-9).converged
        tip, force = simulator.tip / MM, simulator.contact_forces.sum(axis=0) / MM
        found = np.array([*tip, *force, simulator.effort[0] / MM])
        names = ("tip_x", "tip_y", "tip_z", "F_x", "F_y", "F_z", "tension")
        apart = np.abs(found - [row[name] for name in names])
        assert apart[[0, 1]].max() < max(2e-2 * across, 1e-4)  # mm
        assert apart[2] < across
        assert apart[[3, 4, 6]].max() < max(across, 5e-3)  # of 1,500 mN
        assert apart[5] < max(10.0 * across, 5e-3)
