"""A soft ring on a floor with friction: it settles, and rolls where its cables are shortened, as in SOFA."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.sofa_robots import robots_folder
from support.sofa.ring import MM, command, ring

from tauten.model import Robot, Simulator
from tauten.model.numerics import Array

WEIGHT = 0.042 * 9180.0  # mN


@pytest.fixture(scope="module")
def rolling(reference: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Robot, Array]:
    data = robots_folder(reference, "circular_direct.csv")
    curve = np.genfromtxt(data / "circular_direct.csv", delimiter=",", names=True)
    return ring(data, tmp_path_factory.mktemp("ring")), curve


def found_and_given(simulator: Simulator, row: Array) -> tuple[Array, Array]:
    """Middle [mm], force of the floor [mN] and tensions [mN] here and in SOFA: (10,) each."""
    force = simulator.contacts.force.sum(axis=0)
    here = np.concatenate([simulator.tip, force, simulator.effort]) / MM
    names = [*(f"bc_{x}" for x in "xyz"), *(f"F_contact_{x}" for x in "xyz")]
    names += [f"tension{number}" for number in range(1, 5)]
    return here, np.array([row[name] for name in names])


def test_it_falls_on_the_floor_as_in_sofa(rolling: tuple[Robot, Array]) -> None:
    """Three steps; then SOFA loses a contact for one. Its elements are 'large', ours have the polar R."""
    robot, curve = rolling
    simulator = Simulator(robot)
    for row in curve[:3]:
        assert simulator.step(position=command(row)).converged
        here, there = found_and_given(simulator, row)
        assert np.abs(here - there)[:3].max() < 0.01  # mm
        assert np.abs(here - there)[3:].max() < 0.006 * there.max()


@pytest.mark.slow
def test_it_rolls_to_where_sofas_ring_rolls(rolling: tuple[Robot, Array]) -> None:
    """It stands in an unstable place at first. Where the cables tell where it lies it is where SOFA's is.

    30 mm to the right after 1.8 s and back to 12 mm after 2.8 s: 1 mm apart, heights within 0.1 mm, tensions
    within 3 % of the largest. Later both lean over an edge. Ours falls on its side, SOFA's does not, and
    neither does ours with a Young's modulus 1 % larger: the elements, 'large' there and polar here, differ
    by more.
    """
    robot, curve = rolling
    simulator = Simulator(robot)
    for step, row in enumerate(curve[:281], start=1):
        assert simulator.step(position=command(row)).converged
        if step in (181, 281):
            here, there = found_and_given(simulator, row)
            assert abs(here[0] - there[0]) < 1.2 and abs(here[1] - there[1]) < 0.1
            assert abs(here[4] - WEIGHT) < 0.02 * WEIGHT
            assert np.abs(here - there)[6:].max() < 0.03 * there.max()
