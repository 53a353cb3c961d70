"""Campaigns command efforts that take no winch beyond the limits of its position."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.bodies import CABLE, beam_robot, box_mesh

from tauten.model import Robot, Simulator
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Design, Run, run_campaign

SIZE = (0.1, 0.02, 0.02)
LEAST, MOST = -1e-4, 4e-3  # m
UPPER = {**CABLE, "name": "upper", "points": [[x, y, SIZE[2] - z] for x, y, z in CABLE["points"]]}


@pytest.fixture
def beam() -> Robot[NodalBody]:
    """A beam with a cable on each side, whose winches pay out and wind little."""
    robot = beam_robot(box_mesh(SIZE, (6, 2, 2)), SIZE, cables=[CABLE, UPPER])
    limits = replace(robot.limits, position_min=np.full(2, LEAST), position_max=np.full(2, MOST))
    return replace(robot, limits=limits)


def run_of(beam: Robot[NodalBody], effort: list[float]) -> Run:
    """One equilibrium under efforts, pushed sideways."""
    return Run(
        position=np.full((2, 1), np.nan),
        gravity=np.zeros((3, 1)),
        effector_force=np.array([[0.0], [0.0], [0.2]]),
        effort=np.array(effort)[:, None],
    )


def test_a_winch_that_pays_out_no_more_holds_its_cable(
    beam: Robot[NodalBody], tmp_path: Path
) -> None:
    """The force would lengthen one of the cables; the equilibrium is that with this length held."""
    run = run_of(beam, [0.0, 0.0])
    free = Simulator(beam, "none")
    free.load(run.gravity[:, 0], run.effector_force[:, 0])
    assert free.settle(effort=[0.0, 0.0]).converged
    outer = int(np.argmin(free.position))
    assert free.position[outer] < 2.0 * LEAST
    found = run_campaign(beam, Design("held", (run,)), tmp_path)
    assert found.converged.all()
    assert found.position[outer, 0] == pytest.approx(LEAST, abs=1e-9)
    assert found.effort[outer, 0] > 0.0
    held = np.where(np.arange(2) == outer, LEAST, np.nan)
    assert free.settle(held, np.where(np.isnan(held), 0.0, np.nan)).converged
    np.testing.assert_allclose(found.effector[:, 0], free.effector.ravel(), atol=1e-6)


def test_no_effort_winds_a_cable_beyond_its_limit(beam: Robot[NodalBody], tmp_path: Path) -> None:
    found = run_campaign(beam, Design("wound", (run_of(beam, [100.0, 0.0]),)), tmp_path)
    assert found.converged.all()
    assert found.position[0, 0] == pytest.approx(MOST, abs=1e-9)
    assert 0.0 < found.effort[0, 0] < 100.0
