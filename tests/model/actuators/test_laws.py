"""Couplings, springs and mixed commands: laws of equilibria."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import (
    CABLE,
    CHAMBER,
    HOLLOW_SIZE,
    box_mesh,
    hollow_beam,
    pneumatic_robot,
    without,
)

from tauten.model import Simulator
from tauten.model.schema import RobotFileError
from tauten.model.signals import Command, Laws, Springs

UPPER = {**CABLE, "name": "upper", "points": [[0.01, 0.01, 0.018], [0.1, 0.01, 0.018]]}
DRUM: dict[str, object] = {
    "name": "drum", "members": ["tendon", "upper"], "gains": [1.0, -1.0], "pretensions": [2.0, 2.0],
    "max_position": 0.02, "max_effort": 5.0, "max_rate": 0.1,
}  # fmt: skip


def antagonists(**changes: object) -> Simulator:
    robot = pneumatic_robot(cables=[CABLE, UPPER], chambers=[], couplings=[{**DRUM, **changes}])
    return Simulator(robot, "none")


def test_an_antagonistic_pair_is_one_motor() -> None:
    motor = antagonists()
    pair = Simulator(pneumatic_robot(cables=[CABLE, UPPER], chambers=[]), "none")
    assert motor.robot.actuators.names == ("drum",)
    assert motor.settle(effort=[1.5]).converged
    assert pair.settle(effort=[3.5, 0.5]).converged
    np.testing.assert_allclose(motor.effector, pair.effector, atol=1e-6)
    assert motor.position[0] == pytest.approx(pair.position[0] - pair.position[1], abs=1e-6)


def test_a_motor_turned_both_ways_bends_both_ways() -> None:
    motor, heights, efforts = antagonists(), [], []
    for position in (-0.002, 0.0, 0.002):
        assert motor.settle(position=[position]).converged
        assert motor.position[0] == pytest.approx(position, abs=1e-7)
        heights.append(motor.effector[0, 2])
        efforts.append(motor.effort[0])
    assert heights[0] > heights[1] > heights[2]
    assert efforts[0] < efforts[1] < efforts[2]


def test_the_limits_of_members_bound_the_motor() -> None:
    limits = antagonists().robot.limits
    assert (limits.effort_min[0], limits.effort_max[0]) == (-2.0, 2.0)  # no cable pushes


def check_winches_with_gains(motor: Simulator, pair: Simulator) -> None:
    """A motor of gains 2 and −0.5 and pretensions 3 and 1 does what the winches of its two cables do."""
    assert motor.settle(effort=[-1.0]).converged
    assert pair.settle(effort=[1.0, 1.5]).converged
    np.testing.assert_allclose(motor.effector, pair.effector, atol=1e-6)
    assert motor.position[0] == pytest.approx(
        2.0 * pair.position[0] - 0.5 * pair.position[1], abs=1e-6
    )


def test_gains_and_pretensions_count_in_limits_and_efforts() -> None:
    """Tensions are 2 λ + 3 and 1 − λ / 2, neither below zero: −1.5 ≤ λ ≤ 2; the rate is the motor's own."""
    motor = antagonists(gains=[2.0, -0.5], pretensions=[3.0, 1.0])
    limits = motor.robot.limits
    assert (limits.effort_min[0], limits.effort_max[0]) == (-1.5, 2.0)
    assert (limits.rate[0], limits.position_max[0]) == (0.1, 0.02)
    pair = Simulator(pneumatic_robot(cables=[CABLE, UPPER], chambers=[]), "none")
    check_winches_with_gains(motor, pair)


def test_springs_of_a_coupling_count_with_its_gains_and_pretensions() -> None:
    """The motor of a coupling turns by what the winches of its cables would, each times its gain."""
    springs = ({"stiffness": 300.0, "pretension": 0.5}, {"stiffness": 700.0, "pretension": 0.2})
    cables = [
        {**one, "spring": spring} for one, spring in zip((CABLE, UPPER), springs, strict=True)
    ]
    drum = {**DRUM, "gains": [2.0, -0.5], "pretensions": [3.0, 1.0]}
    motor = Simulator(pneumatic_robot(cables=cables, chambers=[], couplings=[drum]), "none")
    pair = Simulator(pneumatic_robot(cables=cables, chambers=[]), "none")
    check_winches_with_gains(motor, pair)


def test_pretensions_that_exclude_rest_are_refused() -> None:
    with pytest.raises(RobotFileError, match=r"couplings\.drum: the limits of its members allow"):
        antagonists(pretensions=[2.0, -1.0])
    only_zero = (
        r"couplings\.drum: the limits of its members allow no effort of its motor but 0: change "
    )
    with pytest.raises(RobotFileError, match=only_zero):
        antagonists(pretensions=None)


def test_two_chambers_on_one_supply_share_its_pressure() -> None:
    """Volumes add, the pressure is the same: the same as one chamber of both surfaces."""
    robot = pneumatic_robot()
    supply = {**DRUM, "name": "supply", "members": ["bellows"], "gains": [1.0], "pretensions": None,
              "max_position": 8e-6, "max_effort": 4e4, "held": "force"}  # fmt: skip
    coupled = pneumatic_robot(chambers=[CHAMBER], couplings=[supply])
    alone, through = Simulator(robot, "none"), Simulator(coupled, "none")
    assert alone.settle(effort=[2e4]).converged
    assert through.settle(effort=[2e4]).converged
    np.testing.assert_allclose(alone.effector, through.effector, atol=1e-9)
    assert coupled.limits.effort_min[0] == -5e3


def test_volumes_of_two_chambers_on_one_supply_add() -> None:
    sides = [np.array([0.0, 0.005, 0.01]), np.array([0.0, 0.015, 0.015])]
    ranges = [(0.01, 0.04), (0.05, 0.09)]
    boxes = [
        (sides[0] + np.array([low, 0, 0]), sides[1] + np.array([high, 0, 0]))
        for low, high in ranges
    ]
    mesh = without(box_mesh(HOLLOW_SIZE, (10, 4, 4)), boxes)
    chambers = [
        {**CHAMBER, "name": name, "inside": [x, 0.01, 0.0125]}
        for name, x in (("near", 0.02), ("far", 0.07))
    ]
    supply = {**DRUM, "name": "supply", "members": ["near", "far"], "gains": [1.0, 1.0],
              "pretensions": None, "max_position": 8e-6, "max_effort": 4e4}  # fmt: skip
    two = Simulator(pneumatic_robot(mesh, chambers=chambers), "none")
    one = Simulator(pneumatic_robot(mesh, chambers=chambers, couplings=[supply]), "none")
    assert two.settle(effort=[2e4, 2e4]).converged
    assert one.settle(position=[two.position.sum()]).converged
    assert one.effort[0] == pytest.approx(2e4, rel=1e-4)
    np.testing.assert_allclose(one.effector, two.effector, atol=1e-7)


def test_a_spring_lengthens_by_its_tension() -> None:
    """The winch travels by the pull of the cable and the stretch of the spring."""
    stiffness, pretension = 300.0, 0.5
    spring = {"stiffness": stiffness, "pretension": pretension}
    rigid = Simulator(pneumatic_robot(cables=[CABLE], chambers=[]), "none")
    soft = Simulator(pneumatic_robot(cables=[{**CABLE, "spring": spring}], chambers=[]), "none")
    assert soft.settle(position=[0.01]).converged
    effort = soft.effort
    assert rigid.settle(effort=effort).converged
    np.testing.assert_allclose(rigid.effector, soft.effector, atol=1e-6)
    stretch = (effort[0] - pretension) / stiffness
    assert rigid.position[0] + stretch == pytest.approx(0.01, abs=1e-7)
    assert soft.position[0] == pytest.approx(0.01, abs=1e-7)
    assert soft.settle(position=[0.0]).converged
    assert 0.0 < soft.effort[0] < pretension  # the robot yields a little
    assert soft.settle(position=[-0.005]).converged
    assert soft.effort[0] == 0.0  # more than the pretension has stretched


@pytest.mark.parametrize(
    ("position", "effort", "text"),
    [
        ([0.0, np.nan], [np.nan, np.nan], "each actuator needs a number in one of them"),
        ([0.0, 0.0], [np.nan, 1.0], "each actuator needs a number in one of them"),
        ([np.nan, 0.0], None, "position: found"),
        (None, [-1.0, 0.0], "effort: found"),
        (None, [1.0, np.inf], "effort: found"),
        (None, None, "each actuator needs a number in one of them"),
    ],
)
def test_bad_commands_are_one_sentence(
    position: list[float], effort: list[float], text: str
) -> None:
    simulator = Simulator(pneumatic_robot(cables=[CABLE]), "none")
    with pytest.raises(ValueError, match=text):
        simulator.step(position=position, effort=effort)


def test_two_forces_at_one_point_cannot_go_two_ways() -> None:
    push = {"name": "one", "point": [0.1, 0.01, 0.01], "direction": [0.0, 0.0, 1.0],
            "max_force": 10.0, "max_travel": 0.05, "max_rate": 1.0}  # fmt: skip
    robot = pneumatic_robot(chambers=[], forces=[push, {**push, "name": "two"}])
    simulator = Simulator(robot, "none")
    assert not simulator.step(position=[0.001, 0.002]).converged
    simulator.reset()
    assert simulator.settle(position=[0.001, 0.001]).converged
    np.testing.assert_allclose(simulator.position, 0.001, atol=1e-8)
    assert simulator.effort[0] == pytest.approx(simulator.effort[1])  # shared evenly


def test_a_cavity_that_no_actuator_uses_changes_nothing() -> None:
    mesh = hollow_beam()
    cable = Simulator(pneumatic_robot(mesh, cables=[CABLE], chambers=[]), "none")
    both = Simulator(pneumatic_robot(mesh, cables=[CABLE]), "none")
    assert cable.settle(position=[0.004]).converged
    assert both.settle(position=[0.004, np.nan], effort=[np.nan, 0.0]).converged
    np.testing.assert_allclose(cable.effector, both.effector, atol=1e-9)


def test_the_merit_of_an_actuator_falls_by_the_work_of_its_effort() -> None:
    """By δ: −λ of a given effort, −(p − δ − s) / f of a spring, the weight of a given position."""
    position, effort = np.array([0.0, 0.02, 0.03, 0.01, 0.01]), np.array([7.0, 0.0, 0.0, 0.0, 0.0])
    by_force = np.array([True, False, False, False, False])
    springs = Springs(
        np.array([0.0, 0.01, 0.02, 0.0, 0.0]), np.array([0.0, 0.003, -0.002, 0.0, 0.0])
    )
    laws = Laws(np.array([False, True, False, True, False]), by_force, springs)
    command, weights = Command.either(by_force, position, effort), np.full(5, 90.0)
    pulled = {0: -7.0, 1: -(0.02 - 0.005 - 0.003) / 0.01, 2: -(0.03 - 0.005 + 0.002) / 0.02,
              3: -90.0, 4: -90.0}  # fmt: skip
    beyond = {0: -7.0, 1: -(0.02 - 0.05 - 0.003) / 0.01, 2: 0.0, 3: 90.0, 4: 0.0}
    for at, slopes in ((0.005, pulled), (0.05, beyond)):  # m, cables are slack at the second one
        for actuator, slope in slopes.items():
            ends = []
            for step in (1e-6, -1e-6):
                delta = np.full(5, at)
                delta[actuator] += step
                ends.append(laws.penalty(command, delta, weights))
            assert (ends[0] - ends[1]) / 2e-6 == pytest.approx(slope, rel=1e-6, abs=1e-6)
