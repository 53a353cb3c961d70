"""The gripper of SoftRobots lifts its cube, as in SOFA: the force of the fingers is the cube's weight."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.sofa_robots import robots_folder
from support.sofa.gripper import GRAVITY, MASS, MM, WAY, Course, gripper_file

from tauten.model import Simulator, load_robot
from tauten.model.numerics import Array

PULL = 0.010  # m
WEIGHT = MASS * GRAVITY  # N, 29.43 mN in SOFA


def closed(simulator: Simulator, start: float, time: float, until: float) -> None:
    """Pull all three cables evenly from a time on.

    Args:
        simulator: at its start.
        start: of the pull [s].
        time: that it takes [s].
        until: time at the end [s].
    """
    h = simulator.robot.h
    for step in range(1, round(until / h) + 1):
        share = float(np.clip((step * h - start) / time, 0.0, 1.0))
        assert simulator.move(position=np.full(3, share * PULL)).converged


def forces(simulator: Simulator) -> tuple[Array, Array]:
    """Of the floor and of the fingers on the cube: (3,) each [N]."""
    found = simulator.contacts
    of_floor = found.contacts.pair == 0
    return found.force[of_floor].sum(axis=0), -found.force[~of_floor].sum(axis=0)


@pytest.mark.long
def test_fingers_that_close_take_the_cube_off_the_floor(reference: Path, tmp_path: Path) -> None:
    data = robots_folder(reference, "grasp_model.npz")
    file = gripper_file(data, tmp_path, Course(up=-1.0, down=10.0, time=1.0))
    simulator = Simulator(load_robot(file))
    height = simulator.tip[1]
    closed(simulator, 0.0, 0.2, 0.25)
    floor, fingers = forces(simulator)
    assert (floor == 0.0).all() and simulator.tip[1] > height + 1e-3
    assert fingers[1] == pytest.approx(WEIGHT, rel=0.02)


@pytest.mark.slow
def test_it_is_lifted_as_far_as_the_gripper_goes(reference: Path, tmp_path: Path) -> None:
    """Down 48 mm, 10 mm of cable, up 48 mm; the cube sticks, and the fingers carry it within 0.1 %."""
    data = robots_folder(reference, "grasp_model.npz")
    file = gripper_file(data, tmp_path, Course(up=0.1, down=1.6, time=0.5))
    simulator = Simulator(load_robot(file))
    start = simulator.tip[1]
    closed(simulator, 0.8, 0.6, 2.6)
    floor, fingers = forces(simulator)
    found = simulator.contacts
    assert (floor == 0.0).all()
    assert simulator.tip[1] > start + WAY  # from where the cube was; the floor is there again
    assert not found.sliding[found.pushing].any()
    assert np.abs(fingers / MM - [0.0, 29.43, 0.0]).max() < 0.05


@pytest.mark.slow
def test_without_friction_the_cube_slips_out(reference: Path, tmp_path: Path) -> None:
    data = robots_folder(reference, "grasp_model.npz")
    file = gripper_file(data, tmp_path, Course(up=-1.0, down=10.0, time=1.0), friction=0.0)
    simulator = Simulator(load_robot(file))
    start = simulator.tip
    closed(simulator, 0.0, 0.2, 0.8)  # s; when it leaves an unstable equilibrium depends on little
    away = np.hypot(*(simulator.tip - start)[[0, 2]])  # across the floor, in whichever direction
    assert (forces(simulator)[1] == 0.0).all() and away > 0.05
