"""A simulated robot is pulled by a spring, and moves as its compliance says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tauten.model import Robot, row_compliance
from tauten.service.frames import SimulatedRobot
from tauten.service.link import OperatorCommand
from tauten.service.setup import load_setup


@pytest.mark.long
def test_a_small_pull_moves_the_tip_as_its_compliance_says(beam_file: Path, beam: Robot) -> None:
    shown = SimulatedRobot(load_setup(beam_file), load_setup(beam_file))
    rest = shown.look.robot.rest
    assert shown.pull(0, None) is None
    end = rest[:3] + np.array([0.0, 0.0, 2e-4])
    force = None
    for _ in range(60):
        force = shown.pull(0, end)
        shown.advance(None, False)
    frame = shown.advance(None, True)
    assert frame is not None
    assert force is not None
    robot = beam.fork()
    rows = robot.rows(robot.rest(), contacts=False)
    system = robot.linearise(robot.rest(), None, replace(robot.integration, static=True))
    H = np.vstack([rows.effectors.dense()[:3], rows.actuators.dense()])
    W = row_compliance(system, H, np.zeros(len(H))).W
    tight = 3 + np.flatnonzero(
        frame.effort > 1e-6
    )  # the winches hold cables that the pull tightens
    assert len(tight)
    held = W[:3, :3] - W[:3, tight] @ np.linalg.solve(W[np.ix_(tight, tight)], W[tight, :3])
    moved = (frame.values - rest)[:3]
    assert moved == pytest.approx(held @ force, abs=0.06 * np.abs(moved).max())
    assert 0.5e-4 < moved[2] < 1.2e-4, "about half way: the spring is as stiff as the free robot"
    assert shown.pull(0, None) is None
    for _ in range(60):
        shown.advance(None, False)
    frame = shown.advance(None, True)
    assert frame is not None
    assert frame.values == pytest.approx(rest, abs=1e-6)


def test_a_refusal_is_forgotten_when_an_order_is_obeyed(beam_file: Path) -> None:
    """That a robot cannot be enabled in a stop was shown for ten seconds after it had been reset."""
    shown = SimulatedRobot(load_setup(beam_file), load_setup(beam_file))
    shown.command(OperatorCommand.RESET)
    assert shown.notes == ("reset is not possible now: there was no stop",)
    shown.command(OperatorCommand.HOLD)
    assert shown.notes == ()
