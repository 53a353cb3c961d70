"""Paths that a basis was not made from."""

import numpy as np
import pytest

from benchmarks.contact_basis import FORCES, held_out_design, sensitivity
from tauten.model import Robot
from tauten.reduction.campaign import Snapshots


@pytest.mark.parametrize("steps", [5, 20])
def test_gravity_forces_and_release(thumb: Robot, steps: int) -> None:
    design, names = held_out_design(thumb, steps)
    assert len(set(names)) == len(names) == len(design.runs) == 5 + 1 + 6 * len(FORCES) + 1
    runs = dict(zip(names, design.runs, strict=True))
    limit = thumb.limits.position_max
    for name, run in runs.items():
        np.testing.assert_allclose(np.linalg.norm(run.gravity, axis=0), 9.81)
        if name != "pull and release":
            assert len(run) == steps
            np.testing.assert_allclose(run.position[:, -1], limit)
            assert (np.diff(run.position) > 0.0).all()
    np.testing.assert_allclose(runs["0.5 N -y"].effector_force[:, 0], [0.0, -0.5, 0.0])
    np.testing.assert_allclose(runs["gravity +z"].gravity[:, 0], [0.0, 0.0, 9.81])
    assert "gravity -z" not in runs, "that is how it hangs anyway"
    release = runs["pull and release"].position[0]
    np.testing.assert_allclose(release, release[::-1])
    assert release.argmax() not in (0, len(release) - 1)


def test_a_stable_path_is_unchanged(thumb: Robot, thumb_ramp: Snapshots) -> None:
    """A perturbation of a millionth moves a robot that does not buckle by micrometres."""
    some = thumb_ramp.select(np.arange(4, len(thumb_ramp), 10))
    apart = sensitivity(thumb, some)
    assert np.isfinite(apart).all()
    assert 0.0 < apart.max() < 2e-5
