"""Where the rows of a step are: held against the rows of the robot, with and without its effectors."""

from __future__ import annotations

import numpy as np
import pytest
from support.effectors import disturbed, solid

from tauten.model import EmptySpace, condense_step, no_forces


@pytest.mark.parametrize("effectors", [True, False])
def test_each_kind_of_rows_is_where_the_layout_says(effectors: bool) -> None:
    robot = solid()
    state = disturbed(robot, np.random.default_rng(3), 1e-3)
    none = no_forces(robot.n_a, 0)
    step = condense_step(robot, EmptySpace(robot.n_c), state, none, True, effectors)
    layout, H = step.layout, step.compliance.H
    rows = robot.rows(state)
    np.testing.assert_array_equal(H[layout.actuators], rows.actuators.dense())
    assert len(H[layout.effectors]) == (robot.effector_layout.n_rows if effectors else 0)
    if effectors:
        np.testing.assert_array_equal(H[layout.effectors], rows.effectors.dense())
        assert layout == robot.layout
    assert len(H[layout.contacts]) == step.n_contacts
    assert len(H[layout.acting]) == robot.n_a + step.n_contacts
    lam = np.arange(1.0, len(H) + 1.0)
    np.testing.assert_array_equal(step.split(lam, 0).effort, lam[layout.actuators])
