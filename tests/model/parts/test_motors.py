"""Motors that drive actuators of several parts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tauten.model import Robot, RobotFileError, Simulator, load_robot


def pair(beam_file: Path, folder: Path, coupling: str) -> Robot:
    """Two beams side by side, each with the cables `lower` and `upper`."""
    parts = [
        f'[[parts]]\nname = "{name}"\nrobot = "{beam_file}"\nposition = [0.0, {y}, 0.0]\n'
        for name, y in (("a", 0.0), ("b", 0.1))
    ]
    path = folder / "pair.toml"
    path.write_text("\n".join(['name = "pair"\ngravity = [0.0, 0.0, 0.0]', *parts, coupling]))
    return load_robot(path)


def coupling(members: str, gains: str, more: str = "") -> str:
    """A table of a file."""
    return f"""
    [[couplings]]
    name = "both"
    members = {members}
    gains = {gains}
    max_position = 0.1
    max_effort = 10.0
    max_rate = 1.0
    {more}
    """


def test_one_motor_pulls_a_cable_of_each_part(beam_file: Path, tmp_path: Path) -> None:
    """Equal gains share one tension: both parts are where each is alone under it, and δ = Σ g δ."""
    robot = pair(beam_file, tmp_path, coupling('["b_lower", "a_lower"]', "[1.0, 0.5]"))
    assert robot.actuators.names == ("both", "a_upper", "b_upper")
    simulator, alone = Simulator(robot, "none"), Simulator(load_robot(beam_file), "none")
    effort = 0.2
    assert simulator.settle(effort=np.array([effort, 0.0, 0.0])).converged
    tips, pulled = [], 0.0
    for gain in (0.5, 1.0):
        alone.reset()
        assert alone.settle(effort=np.array([gain * effort, 0.0])).converged
        tips.append(alone.effector)
        pulled += gain * alone.position[0]
    tips[1] = tips[1] + [0.0, 0.1, 0.0]
    np.testing.assert_allclose(simulator.effector, np.concatenate(tips), atol=1e-8)
    np.testing.assert_allclose(simulator.position[0], pulled, atol=1e-9)


def test_limits_of_members_hold_for_the_motor(beam_file: Path, tmp_path: Path) -> None:
    single = load_robot(beam_file).limits
    robot = pair(beam_file, tmp_path, coupling('["a_lower", "b_lower"]', "[1.0, 2.0]"))
    allowed = min(10.0, float(single.effort_max[0]) / 2.0)
    assert robot.limits.effort_max[0] == pytest.approx(allowed)
    assert robot.limits.position_max[0] == 0.1
    assert robot.limits.effort_max[1] == single.effort_max[1]


@pytest.mark.parametrize("held", ["position", "force"])
def test_a_motor_keeps_in_a_hold_what_its_table_says(
    beam_file: Path, tmp_path: Path, held: str
) -> None:
    table = coupling('["a_lower", "b_lower"]', "[1.0, 1.0]", f'held = "{held}"')
    laws = pair(beam_file, tmp_path, table).actuators.laws
    assert laws.held_by_force.tolist() == [held == "force", False, False]


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (
            coupling('["a_lower", "c_lower"]', "[1.0, 1.0]"),
            r"couplings\.0: member 'c_lower' is not defined",
        ),
        (
            coupling('["a_lower", "b_lower"]', "[1.0, 1.0]", "pretensions = [1.0, 1.0]"),
            "drums and pretensions stand in the file of a part",
        ),
        (coupling('["a_lower", "b_lower"]', "[1.0, 1.0]") * 2, "is driven by another coupling"),
    ],
)
def test_what_is_wrong_is_named(beam_file: Path, tmp_path: Path, table: str, message: str) -> None:
    with pytest.raises(RobotFileError, match=message):
        pair(beam_file, tmp_path, table)
