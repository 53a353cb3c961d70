"""Equilibria of robots of other projects, far from rest (reference data README)."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from support.robots.thumb import write_thumb

from benchmarks.physics import TRUNK_CABLES, diamond, trunk
from tauten.model import Ending, Robot, Simulator, State, load_robot
from tauten.model.points.paths import SHORTEST

HANGING = (0.0, -9.81, 0.0)
FEW_DOZEN = 80  # linearised steps from rest to the end of the range, at most


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
        assert simulator.settle(position=[1e-3 * row["imposed_L0"]]).converged
        tip = [row["tip_x"], row["tip_y"], row["tip_z"]]
        assert np.linalg.norm(1e3 * simulator.effector[0] - tip) < 0.05
        assert abs(1e3 * simulator.effort[0] - row["tension_L0"]) < 0.3


@pytest.mark.long
@pytest.mark.parametrize(
    "gravity", [pytest.param((0.0, 0.0, 0.0), marks=pytest.mark.slow), HANGING]
)
@pytest.mark.parametrize("cables", [("L0",), TRUNK_CABLES])
@pytest.mark.parametrize(
    "position",
    [*(pytest.param(pull, marks=pytest.mark.slow) for pull in (0.02, 0.025, 0.035)), 0.05],
)
def test_trunk_settles_from_rest_under_one_cable(
    data: Path, cables: tuple[str, ...], gravity: tuple[float, ...], position: float
) -> None:
    simulator = Simulator(trunk(data, cables, gravity), contact="none")
    report = simulator.settle(position=[position] + [0.0] * (len(cables) - 1))
    assert report.converged, report
    assert report.iterations < FEW_DOZEN
    assert simulator.position[0] == pytest.approx(position, abs=1e-6)


@pytest.mark.long
@pytest.mark.parametrize(
    "gravity", [pytest.param((0.0, 0.0, 0.0), marks=pytest.mark.slow), HANGING]
)
def test_trunk_settles_from_rest_under_pairs(data: Path, gravity: tuple[float, ...]) -> None:
    robot, taken = trunk(data, gravity=gravity), []
    for first, second in combinations(range(4), 2):
        if second - first == 2:
            continue  # opposite cables compress the trunk
        simulator, position = Simulator(robot, contact="none"), np.zeros(8)
        position[[first, second]] = 0.05
        report = simulator.settle(position=position)
        assert report.converged, (first, second, report)
        taken.append(report.iterations)
    print(f"linearised steps: median {np.median(taken):.0f}, most {max(taken)}")


@pytest.mark.slow
@pytest.mark.parametrize("cable", [1, 2])
def test_trunk_settles_where_a_branch_ends_on_the_way(data: Path, cable: int) -> None:
    """With gravity across it; of the third cable the branch ends at 44 mm, and the trunk snaps."""
    simulator = Simulator(trunk(data, gravity=HANGING), contact="none")
    position = np.zeros(8)
    position[cable] = 0.05
    report = simulator.settle(position=position)
    assert report.converged, report
    assert simulator.position[cable] == pytest.approx(0.05, abs=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("effort", [4.6, 10.0])
def test_diamond_settles_with_a_leg_at_its_winch(data: Path, effort: float) -> None:
    """Above about 5 N the cable is wound in whole: its end stays where the winch is."""
    simulator = Simulator(diamond(data), contact="none")
    report = simulator.settle(effort=[effort, 0.0, 0.0, 0.0])
    assert report.converged, report
    assert report.iterations < FEW_DOZEN
    if effort == 10.0:
        length = 0.08828363 - simulator.position[0]  # m, distance of winch and leg at rest
        assert 0.0 < length < SHORTEST


@pytest.mark.long
def test_state_of_a_failed_search_is_the_last_equilibrium(tmp_path: Path) -> None:
    """A pull no cable can reach: the share that was reached is an equilibrium, and it is named."""
    thumb = load_robot(write_thumb(tmp_path))
    simulator, again = Simulator(thumb, contact="none"), Simulator(thumb, contact="none")
    report = simulator.settle(position=[0.08])  # m, longer than the thumb
    assert not report.converged
    assert report.ending is not Ending.SETTLED
    assert 0.0 < report.share < 1.0
    assert np.isfinite(simulator.state.q).all()
    assert simulator.position[0] == pytest.approx(0.08 * report.share, abs=1e-6)
    again.start_from(simulator.state, simulator.forces)
    assert again.settle(position=simulator.position).iterations <= 2


def settle_from_random_starts(robot: Robot, count: int) -> None:
    """From states moved by smooth random fields of up to a tenth of the robot's size."""
    generator, taken, failed = np.random.default_rng(0), [], []
    rest = robot.rest()
    x = rest.q.reshape(-1, 3)
    for _ in range(count):
        waves = generator.uniform(-40.0, 40.0, (3, 3))  # 1/m
        phase = generator.uniform(0.0, 2.0 * np.pi, 3)
        moved = x + 0.1 * robot.size * np.sin(x @ waves + phase) * generator.uniform()
        simulator = Simulator(robot, contact="none")
        simulator.start_from(State(moved.ravel(), rest.v))
        report = simulator.settle(
            position=generator.uniform(0.0, 0.8, robot.n_a) * robot.limits.position_max
        )
        taken.append(report.iterations)
        assert np.isfinite(simulator.state.q).all()
        if not report.converged:
            failed.append(report)
    print(f"{count} starts: median {np.median(taken):.0f} steps, most {max(taken)}, {failed}")
    assert all(report.ending is not Ending.SETTLED for report in failed)
    assert len(failed) <= 0.02 * count


@pytest.mark.long
def test_finger_settles_from_random_starts(finger: Robot) -> None:
    settle_from_random_starts(finger, 8)


@pytest.mark.slow
def test_finger_settles_from_many_random_starts(finger: Robot) -> None:
    settle_from_random_starts(finger, 200)
