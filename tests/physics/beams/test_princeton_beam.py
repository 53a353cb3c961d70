"""The Princeton beam: a cantilever strip bent in both directions and twisted by one tip force.

Dowell, Traybar and Hodges, J. of Sound and Vibration 50, 1977. The references are tip displacements of
ANSYS' beam elements from Obrezkov, Mikkola, Matikainen et al., "Performance review of locking alleviation
methods for continuum ANCF beam elements", Nonlinear Dynamics 109, 2022, as EXUDYN's test
`main/pythonDev/TestModels/ANCFBeamTest.py` lists them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.exact_rod import Rod, stiffness
from support.robots.beam_robots import build, path_of_beams, rectangle, under_force

from tauten.model import Robot
from tauten.model.beams import BeamBody, Material, bar
from tauten.model.numerics import Array

LENGTH, WIDTH, HEIGHT = 0.508, 12.377e-3, 3.2024e-3
E, NU, RHO = 71.7e9, 0.31, 2700.0
ANGLES = np.radians([0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0])  # of the load from the wide side

# Tip displacement [m] across the wide side and across the thin one at each of the angles.
WIDE_SIDE = {
    8.896: [0.010714, 0.010613, 0.010112, 0.008837, 0.006605, 0.003539, 0.0],
    13.345: [0.016064, 0.016458, 0.016659, 0.015186, 0.011578, 0.006249, 0.0],
}
THIN_SIDE = {
    8.896: [0.0, 0.042082, 0.079395, 0.108988, 0.129888, 0.142194, 0.146246],
    13.345: [0.0, 0.064358, 0.117736, 0.156467, 0.181862, 0.196097, 0.200678],
}


def strip(folder: Path, count: int) -> Robot[BeamBody]:
    """The beam along x, its wide side along y."""
    nodes = np.outer(np.linspace(0.0, LENGTH, count + 1), [1.0, 0.0, 0.0])
    beams = path_of_beams(nodes, (0.0, 0.0, 1.0), "strip")
    profile = rectangle("strip", WIDTH, HEIGHT)
    return build(folder, nodes, beams, [profile], (E, NU, RHO), [0], count)


def moved(robot: Robot[BeamBody], load: float, angle: float) -> Array:
    """Displacement of the tip (3,) [m] under a force [N] at an angle [rad] from −y."""
    force = load * np.array([0.0, -np.cos(angle), np.sin(angle)])
    _, positions = under_force(robot, [0.5 * force, force], 1e-9)
    return positions[-1] - [LENGTH, 0.0, 0.0]


@pytest.mark.parametrize("load", [8.896, 13.345])
def test_tip_at_every_angle(tmp_path: Path, load: float) -> None:
    """Within 0.3 % of the deflection, and 0.2 mm, of another program."""
    robot = strip(tmp_path, 32)
    for angle, wide, thin in zip(ANGLES, WIDE_SIDE[load], THIN_SIDE[load], strict=True):
        found = moved(robot, load, angle)
        error = np.hypot(-found[1] - wide, found[2] - thin)
        assert error < 3e-3 * np.hypot(wide, thin), np.degrees(angle)
        assert abs(-found[1] - wide) < 2e-4, np.degrees(angle)
        assert abs(found[2] - thin) < 2e-4, np.degrees(angle)


def test_tip_converges_to_the_exact_rod(tmp_path: Path) -> None:
    """What is left to ANSYS above is no error of the elements: they converge to the rod they approximate."""
    load, angle = 13.345, ANGLES[3]
    found = [moved(strip(tmp_path, count), load, angle) for count in (16, 32, 64)]
    force = load * np.array([0.0, -np.cos(angle), np.sin(angle)])
    section = stiffness(bar(WIDTH, HEIGHT), Material(E, NU, RHO))
    rod = Rod(LENGTH, lambda s: 1.0, lambda s: np.zeros(3), np.eye(3), lambda s: section)
    exact = rod.tip(force, found[-1] + [LENGTH, 0.0, 0.0]) - [LENGTH, 0.0, 0.0]
    errors = np.linalg.norm(np.array(found) - exact, axis=1)
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(2.0, abs=0.05)
    np.testing.assert_allclose(found[-1] + (found[-1] - found[-2]) / 3.0, exact, atol=1e-7)
