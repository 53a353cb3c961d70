"""Which way the cross-section of a beam lies whose file does not say it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.beam_robots import build, rectangle

from tauten.model import Simulator

LENGTH, WIDTH, HEIGHT, YOUNG = 0.5, 0.02, 0.002, 1e9


@pytest.mark.parametrize(
    ("along", "thin"),
    [
        ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
        ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
        ([0.8, 0.0, 0.6], [0.0, 1.0, 0.0]),  # y lies across it more than z
    ],
)
def test_a_strip_is_thin_along_z_or_what_lies_across_it_most(
    tmp_path: Path, along: list[float], thin: list[float]
) -> None:
    """The end bends by F L³ / (3 E I) along the thin direction, I = w h³ / 12."""
    nodes = np.outer(np.linspace(0.0, LENGTH, 6), along)
    beams = [{"ends": [i, i + 1], "profile": "strip"} for i in range(5)]
    profile = rectangle("strip", WIDTH, HEIGHT)
    robot = build(tmp_path, nodes, beams, [profile], (YOUNG, 0.3, 1000.0), [0], 5)
    force = 1e-4  # N
    loaded = robot.loaded(np.zeros(3), force * np.array(thin))
    simulator = Simulator(loaded, contact="none")
    assert simulator.settle(effort=[0.0]).converged
    moved = simulator.effector[0] - nodes[-1]
    expected = force * LENGTH**3 / (3.0 * YOUNG * WIDTH * HEIGHT**3 / 12.0)
    assert moved @ thin == pytest.approx(expected, rel=1e-3)
