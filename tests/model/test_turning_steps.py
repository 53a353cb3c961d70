"""Steps that turn elements: exact where a body turns, and straight to first order."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tauten.model.mesh import TetMesh
from tauten.model.tetra.turning import TurningSteps

CORNERS = np.vstack([np.zeros(3), np.eye(3), np.ones(3)])
TETS = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])  # both positively oriented


@pytest.fixture
def steps() -> TurningSteps:
    """Of two tetrahedra whose first node is fixed."""
    return TurningSteps(TetMesh(CORNERS, TETS), np.array([-1, 0, 3, 6, 9]))


def test_a_rate_of_rotation_becomes_the_rotation(steps: TurningSteps) -> None:
    """From a state that is turned and stretched."""
    F = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix() @ np.diag([1.2, 0.9, 1.1])
    x, axis = CORNERS @ F.T, np.array([0.7, 0.4, -0.9])
    u = np.cross(axis, x)[1:].ravel()
    expected = x @ Rotation.from_rotvec(axis).as_matrix().T
    np.testing.assert_allclose(x[1:].ravel() + steps.turned(x, u), expected[1:].ravel(), atol=1e-7)


def test_it_differs_from_a_straight_step_in_second_order(steps: TurningSteps) -> None:
    x = CORNERS + 0.05 * np.random.default_rng(0).standard_normal(CORNERS.shape)
    x[0] = 0.0
    u = np.random.default_rng(1).standard_normal(12)
    changes = [np.linalg.norm(steps.turned(x, s * u) - s * u) for s in (0.01, 0.005)]
    assert changes[0] / changes[1] == pytest.approx(4.0, rel=0.05)


def test_inverted_and_flat_elements_stay_finite(steps: TurningSteps) -> None:
    for x in (CORNERS * np.array([1.0, 1.0, 0.0]), -CORNERS):
        assert np.isfinite(steps.turned(x, np.ones(12))).all()
