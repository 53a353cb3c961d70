"""A tapered cantilever whose cross-section stands obliquely, pulled aside, against the exact rod.

Each beam has the cross-section of its middle; those of the exact rod (`support.exact_rod`) change evenly.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.exact_rod import Rod, stiffness
from support.robots.beam_robots import build, rectangle, under_force

from tauten.model.beams import Material, bar
from tauten.model.numerics import Array

LENGTH = 0.3  # m
MATERIAL = Material(1e7, 0.3, 1000.0)
UP = (0.0, float(np.sin(0.5)), float(np.cos(0.5)))
FORCE = np.array([0.0, 0.02, -0.03])  # N


def shape(along: float) -> tuple[float, float]:
    """Width and height of the cross-section at a distance from the clamp [m]."""
    return 0.012 - 0.02 * along, 0.006 - 0.008 * along


def tip(folder: Path, count: int) -> Array:
    """Position of the tip (3,) [m] with so many beams."""
    along = np.linspace(0.0, LENGTH, count + 1)
    nodes = np.stack([along, 0.0 * along, 0.0 * along], axis=1)
    middles = 0.5 * (along[1:] + along[:-1])
    profiles = [rectangle(f"at{i}", *shape(float(s))) for i, s in enumerate(middles)]
    beams = [{"ends": [i, i + 1], "profile": f"at{i}", "up": UP} for i in range(count)]
    robot = build(folder, nodes, beams, profiles, (1e7, 0.3, 1000.0), [0], count)
    return under_force(robot, [0.3 * FORCE, 0.6 * FORCE, FORCE], 1e-10)[1][-1]


@pytest.mark.long
def test_a_tapered_beam_bends_aside_as_the_exact_rod(tmp_path: Path) -> None:
    """To second order; the tip moves by half of the length."""
    frame = np.stack([[1.0, 0.0, 0.0], np.cross(UP, [1.0, 0.0, 0.0]), UP], axis=1)
    found = [tip(tmp_path, count) for count in (8, 16, 32)]
    rod = Rod(
        LENGTH,
        lambda s: 1.0,
        lambda s: np.zeros(3),
        frame,
        lambda s: stiffness(bar(*shape(s)), MATERIAL),
    )
    exact = rod.tip(FORCE, found[-1])
    assert np.linalg.norm(exact - [LENGTH, 0.0, 0.0]) > 0.4 * LENGTH
    errors = np.linalg.norm(np.array(found) - exact, axis=1)
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2.0, atol=0.03)
    assert errors[-1] < 5e-4 * LENGTH
