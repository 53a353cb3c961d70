"""Laws of the rows of a step: what a solved step obeys, row by row."""

from __future__ import annotations

import numpy as np
from support.robots.bodies import CABLE, pneumatic_robot

from tauten.model import (
    Command,
    EmptySpace,
    condense_step,
    forward_step,
    no_forces,
    sorted_rows,
)
from tauten.model.step import NO_ENRICHMENT

UPPER = {**CABLE, "name": "upper", "points": [[0.01, 0.01, 0.018], [0.1, 0.01, 0.018]]}
PUSH = {"name": "push", "point": [0.1, 0.01, 0.01], "direction": [0.0, 3.0, 4.0],
        "max_force": 1.0, "max_travel": 0.1, "max_rate": 1.0}  # fmt: skip


def test_a_solved_step_obeys_the_law_of_every_row() -> None:
    robot = pneumatic_robot(cables=[CABLE, UPPER], forces=[PUSH])
    none = no_forces(robot.n_a, 0)
    step = condense_step(robot, EmptySpace(robot.n_c), robot.rest(), none, True, True)
    names = robot.actuators.names
    position, effort = np.full(robot.n_a, np.nan), np.full(robot.n_a, np.nan)
    position[names.index(CABLE["name"])] = 3e-2
    position[names.index("upper")] = -5e-2  # slack
    position[names.index("push")] = -1e-3
    effort[np.isnan(position)] = 2e3
    command = Command(position, effort)
    rows = sorted_rows(step, command)
    found = [rows.forced, rows.equal, rows.unilateral]
    acting = np.arange(step.layout.n_e, len(step.compliance))
    np.testing.assert_array_equal(np.sort(np.concatenate(found)), acting)
    assert (len(rows.forced), len(rows.equal), len(rows.cables)) == (1, 1, 2)
    solved = forward_step(step, NO_ENRICHMENT, none, command)
    lam = solved.lam
    apart = solved.delta.copy()
    apart[step.layout.actuators] -= np.where(command.by_position, position, 0.0)
    np.testing.assert_array_equal(lam[rows.forced], 2e3)
    np.testing.assert_allclose(apart[rows.equal], 0.0, atol=1e-10)
    assert (lam[rows.unilateral] >= 0.0).all() and (apart[rows.unilateral] > -1e-9).all()
    np.testing.assert_allclose(lam[rows.unilateral] * apart[rows.unilateral], 0.0, atol=1e-9)
    assert (lam[rows.cables] > 0.0).tolist() == [True, False]
