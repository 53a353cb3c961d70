"""Natural frequencies against beam theory and against one mass on a spring."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import beam_config, box_mesh

from tauten.model.body import natural_frequencies
from tauten.model.load import build_robot
from tauten.model.mesh import quadratic_mesh
from tauten.model.schema import RobotConfig

LENGTH, WIDTH, HEIGHT = 0.2, 0.01, 0.014
E, DENSITY = 1e6, 1000.0


def test_a_slender_cantilever_vibrates_as_beam_theory_says() -> None:
    """Bending about both axes, f = (β L)² / (2 π L²) √(E I / (ρ A)); ν = 0, slender: L / height = 14."""
    size = (LENGTH, WIDTH, HEIGHT)
    config = RobotConfig.model_validate(
        beam_config(
            size,
            mesh={"file": "beam.vtu", "element": "quadratic"},
            material={"young_modulus": E, "poisson_ratio": 0.0, "density": DENSITY},
        )
    )
    robot = build_robot(config, quadratic_mesh(box_mesh(size, (20, 1, 1))), "beam")
    found = natural_frequencies(robot.body, robot.rest(), 4)
    theory = [
        root**2 / (2.0 * np.pi * LENGTH**2) * np.sqrt(E * side**2 / (12.0 * DENSITY))
        for root in (1.87510407, 4.69409113)
        for side in (WIDTH, HEIGHT)
    ]
    np.testing.assert_allclose(found, sorted(theory), rtol=0.04)
    assert found[0] == pytest.approx(theory[0], rel=0.015)


def test_frequencies_are_those_of_the_dense_problem() -> None:
    size = (0.06, 0.02, 0.02)
    config = RobotConfig.model_validate(beam_config(size))
    robot = build_robot(config, box_mesh(size, (3, 1, 1)), "beam")
    _, values = robot.forces(robot.rest(), exact=True)
    K = np.zeros((robot.n, robot.n))
    columns = np.repeat(np.arange(robot.n), np.diff(robot.body.pattern.indptr))
    K[robot.body.pattern.indices, columns] = values
    scaled = K / np.sqrt(np.outer(robot.body.tetrahedra.mass, robot.body.tetrahedra.mass))
    expected = np.sqrt(np.linalg.eigvalsh(scaled)[:5]) / (2.0 * np.pi)
    np.testing.assert_allclose(
        natural_frequencies(robot.body, robot.rest(), 5), expected, rtol=1e-8
    )
