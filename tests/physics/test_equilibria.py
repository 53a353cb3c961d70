"""Equilibria of robots of other projects, far from rest (reference data README)."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from support.sofa_robots import TRUNK_CABLES, trunk

from tauten.model import Simulator

HANGING = (0.0, -9.81, 0.0)
FEW_DOZEN = 120  # linearised steps from rest to the end of the range, at most


@pytest.fixture(scope="module")
def data(reference: Path) -> Path:
    folder = reference / "sofa_robots"
    if not folder.exists():
        pytest.skip(f"no folder {folder}")
    return folder


def test_trunk_follows_sofas_curve(data: Path) -> None:
    """Within the README's tolerance: 0.04 mm, and 0.2 mN of tension, on the whole curve."""
    curve = np.genfromtxt(data / "trunk_L0_fpolar.csv", delimiter=",", names=True)
    settled = curve[curve["last_max_dx"] < 2e-6]
    settled = settled[settled["imposed_L0"] <= 40.0]
    assert len(settled) > 10
    simulator = Simulator(trunk(data, ("L0",)), contact="none")
    for row in settled:
        assert simulator.settle(pull=[1e-3 * row["imposed_L0"]]).converged
        tip = [row["tip_x"], row["tip_y"], row["tip_z"]]
        assert np.linalg.norm(1e3 * simulator.effector[0] - tip) < 0.05
        assert abs(1e3 * simulator.tension[0] - row["tension_L0"]) < 0.3


@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0), HANGING])
@pytest.mark.parametrize("cables", [("L0",), TRUNK_CABLES])
@pytest.mark.parametrize("pull", [0.02, 0.025, 0.035, 0.05])
def test_trunk_settles_from_rest_under_one_cable(
    data: Path, cables: tuple[str, ...], gravity: tuple[float, ...], pull: float
) -> None:
    simulator = Simulator(trunk(data, cables, gravity), contact="none")
    report = simulator.settle(pull=[pull] + [0.0] * (len(cables) - 1))
    assert report.converged, report
    assert report.iterations < FEW_DOZEN
    assert simulator.pull[0] == pytest.approx(pull, abs=1e-6)


@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0)])
def test_trunk_settles_from_rest_under_pairs(data: Path, gravity: tuple[float, ...]) -> None:
    robot, taken = trunk(data, gravity=gravity), []
    for first, second in combinations(range(4), 2):
        if second - first == 2:
            continue  # opposite cables compress the trunk
        simulator, pull = Simulator(robot, contact="none"), np.zeros(8)
        pull[[first, second]] = 0.05
        report = simulator.settle(pull=pull)
        assert report.converged, (first, second, report)
        taken.append(report.iterations)
    print(f"linearised steps: median {np.median(taken):.0f}, most {max(taken)}")
    assert max(taken) < FEW_DOZEN
