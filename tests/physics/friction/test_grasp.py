"""Two soft fingers lift a cube by friction: equilibrium of forces, and slip."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.examples import changed, example

from tauten.model import load_robot

GRASP = example("08_grasp")
EDGE, DENSITY, FRICTION = 0.024, 1000.0, 0.5


@pytest.mark.long
@pytest.mark.parametrize(
    ("friction", "mass"),
    [
        pytest.param(1.0, 1.0, marks=pytest.mark.slow),
        pytest.param(0.8, 1.2, id="20 % wrong"),
        pytest.param(0.2, 1.0, id="too little"),
    ],
)
def test_a_cube_is_held_where_friction_suffices(
    friction: float, mass: float, tmp_path: Path
) -> None:
    """Held: the fingers carry the weight, within 1 %. Otherwise it slips and is left behind.

    Args:
        friction: relative to that of the file.
        mass: relative to that of the file.
        tmp_path: for the files.
    """
    changed(tmp_path, "cube.toml", (f"density = {DENSITY}", f"density = {mass * DENSITY}"))
    scale = (f"friction = {FRICTION}", f"friction = {friction * FRICTION}")
    robot = load_robot(changed(tmp_path, "grasp.toml", scale))
    *_, simulator = GRASP["carry"](robot, until=GRASP["TOP"] if friction > 0.5 else 0.35)
    height = GRASP["cube"](simulator).mean(axis=0)[2]
    weight = mass * DENSITY * EDGE**3 * 9.81
    force = GRASP["grip"](simulator)
    if friction < 0.5:
        assert height < EDGE < simulator.tip[2]
        assert abs(force[2]) < 0.5 * weight
    else:
        assert height > 0.09
        np.testing.assert_allclose(force, [0.0, 0.0, weight], atol=0.01 * weight)
        found = simulator.contacts
        held = (found.contacts.pair == 0) & found.pushing
        assert not found.sliding[held].any() and found.margin[held].sum() > 0.1 * weight
