"""Efforts that couplings keep where their motor has none: damping does not know them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from support.robots.combinations import END, add, every, pair_of_cables, robot_with, write_networks

from tauten.model.beams import BeamBody
from tauten.model.constraints import ConstrainedBody
from tauten.model.numerics import Array
from tauten.model.tetra import NodalBody

RIGID = add("rigid", name="plate", region={**END, "body": "body"})


def damped(settings: dict[str, Any]) -> None:
    """Damping proportional to the stiffness of the material."""
    settings["integration"] = {"rayleigh_stiffness": 0.01}


@pytest.mark.parametrize("body", ["mesh", "beam body", "network of beams"])
def test_damping_of_a_reduced_robot_is_that_of_the_material(body: str, tmp_path: Path) -> None:
    write_networks(tmp_path)
    found = []
    for tension in (1.0, 4.0):
        pair = pair_of_cables("differential", {}, pretensions=[tension, tension])
        robot = robot_with([("body", body), ("reduction", "state basis")], tmp_path, pair, damped)
        force, C = robot.body.damping_at(robot.rest(), robot.integration)
        assert force is None
        found.append(C)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9, atol=1e-9 * np.abs(C).max())


@pytest.mark.parametrize("kind", ["mesh", "mesh with a plate", "network of beams"])
def test_damping_is_that_of_the_material(kind: str, tmp_path: Path) -> None:
    """Pretensions turn with the body and change its tangent, but not the stiffness that damps."""

    write_networks(tmp_path)

    def stiffness(tension: float) -> tuple[Array, Array]:
        pair = pair_of_cables("differential", {}, pretensions=[tension, tension])
        plate = [RIGID] if kind == "mesh with a plate" else []
        chosen = [("body", kind)] if kind == "network of beams" else []
        robot = robot_with(chosen, tmp_path, every(pair, damped, *plate))
        body, state = cast("NodalBody | ConstrainedBody | BeamBody", robot.body), robot.rest()
        _, K, D = body.forces_and_stiffness(state, None)
        np.testing.assert_allclose(D, body.stiffness(state), rtol=1e-9, atol=1e-9 * np.abs(D).max())
        return K, D

    (K, D), (more_K, more_D) = stiffness(1.0), stiffness(4.0)
    np.testing.assert_allclose(more_D, D, rtol=1e-9, atol=1e-9 * np.abs(D).max())
    assert np.abs(more_K - K).max() > 1.0
