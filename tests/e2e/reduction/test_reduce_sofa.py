"""`tauten reduce --states` with its defaults on robot files of SOFA: do its errors hold at other equilibria?

Those are equilibria of the full model under random tensions or pressures and payloads of no campaign.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from sofa_robots import port
from support.processes import run_main
from support.robots.sofa_robots import robots_folder

from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.reduction.campaign import Snapshots, command_range, narrowed, payload
from tauten.reduction.state import StateBasis, reduced_robot

COUNT = 30  # equilibria
LEAST = 20  # of them within the range of the basis
GOAL = 1e-3  # m, what the command aims at
# Times the claimed largest error, which as many equilibria of another choice may exceed
BEYOND = 1.5

pytestmark = pytest.mark.slow


@dataclass
class Made:
    """A robot with the state basis that the command made, and what it said."""

    robot: Robot
    states: StateBasis
    said: str


def made(name: str, reference: Path, folder: Path, capsys: pytest.CaptureFixture[str]) -> Made:
    """What the command makes of the robot file of a scene."""
    robot = port(robots_folder(reference, "trunk.vtk"), folder, name)
    places = ("--out", folder / f"{name}.basis", "--snapshots", folder / "campaign")
    assert run_main("reduce", folder / f"{name}.toml", "--states", *places) == 0
    said = capsys.readouterr().out
    return Made(robot, StateBasis.load(folder / f"{name}.states"), said)


def reached(folder: Path) -> Array:
    """Positions (n_a, s) of the campaign over the whole range."""
    return np.hstack([Snapshots.load(path).position for path in folder.glob("*.snapshots")])


def errors(found: Made, within: Robot) -> Array:
    """Distances of the tips [m] where the full model's positions are within the limits of a robot."""
    full, small = Simulator(found.robot), Simulator(reduced_robot(found.robot, found.states))
    commands, limits = command_range(within), within.limits
    rng = np.random.default_rng(7)
    apart = []
    for _ in range(3 * COUNT):
        command = commands.command(rng.uniform(0.0, 1.0, found.robot.n_a))
        push = rng.standard_normal(3)
        push *= rng.uniform() * payload(found.robot, 1) / np.linalg.norm(push)
        for simulator in (full, small):
            simulator.load(found.robot.gravity, push)
            simulator.reset()
        if not full.settle(command.position, command.effort).converged:
            continue
        inside = (limits.position_min <= full.position) & (full.position <= limits.position_max)
        if inside.all() and len(apart) < COUNT:
            assert small.settle(full.position).converged
            apart.append(np.linalg.norm(full.effector - small.effector, axis=1).max())
    return np.array(apart)


@pytest.mark.parametrize("name", ["trunk", "gripper_finger", "pneunets"])
def test_the_claimed_error_holds_at_other_equilibria(
    name: str, reference: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = made(name, reference, tmp_path, capsys)
    origin = found.states.origin
    assert f"{1e3 * origin.tip_max:.3g} mm at most on paths held out" in found.said
    assert origin.tip_max <= GOAL
    within = narrowed(found.robot, reached(tmp_path / "campaign"), origin.position_share)
    apart = errors(found, within)
    assert len(apart) >= LEAST
    assert apart.mean() <= BEYOND * origin.tip_mean
    assert apart.max() <= BEYOND * origin.tip_max
