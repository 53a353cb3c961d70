"""`tauten reduce --states` for every kind of body: a file that serves, with its errors where held out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.processes import run_main
from support.robots.short_arm import write_short_arm
from support.robots.thumb import write_thumb

from tauten.controller import Controller
from tauten.model import load_robot
from tauten.reduction.state import ReducedBody, StateBasis
from tauten.service.setup import load_setup

KINDS = {
    "smoothed": {"element": "smoothed"},
    "smoothed, regions": {"element": "smoothed", "materials": True},
    "quadratic": {"element": "quadratic"},
    "neo-hookean": {"law": "neo-hookean"},
    "smoothed, yeoh": {"element": "smoothed", "silicone": "ecoflex-00-30"},
}


def write_kind(folder: Path, kind: dict[str, object]) -> Path:
    """The thumb with other elements, laws or materials by region."""
    file = write_thumb(folder)
    text = file.read_text()
    if "element" in kind:
        text = text.replace('"thumb.vtu"', f'"thumb.vtu", element = "{kind["element"]}"')
    if "law" in kind:
        text = text.replace("material = {", f'material = {{law = "{kind["law"]}", ')
    if "silicone" in kind:
        new = f'material = {{law = "yeoh", silicone = "{kind["silicone"]}", young_modulus = 600000.0, '
        start = text.index("material = {")
        text = text[:start] + new + "density = 1070.0}" + text[text.index("}", start) + 1 :]
    if "materials" in kind:
        box = "{lower = [0.0, 0.0, -0.05], upper = [0.004, 0.015, 0.0]}"
        text += f"\n[[materials]]\nregion = {box}\nyoung_modulus = 900000.0\npoisson_ratio = 0.4\n"
        text += "density = 1200.0\n"
    file.write_text(text)
    return file


@pytest.mark.parametrize(
    "kind",
    [
        pytest.param(
            kind, marks=[] if kind in ("linear", "quadratic, mooney-rivlin") else [pytest.mark.slow]
        )
        for kind in sorted(KINDS)
    ],
)
def test_reduce_states_of_every_kind(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write_kind(tmp_path, KINDS[kind])
    places = ("--out", tmp_path / "thumb.basis", "--snapshots", tmp_path / "campaign")
    more = ("--design", "ramp", "--step", 4e-4, "--k", 3, "--states", "--state-modes", 8)
    assert run_main("reduce", file, *more, *places) == 0
    said = capsys.readouterr().out
    states = StateBasis.load(tmp_path / "thumb.states")
    origin = states.origin
    assert f"{origin.sample} of " in said
    assert origin.tip_max < 5e-4  # of 50 mm
    assert origin.robot_digest == load_robot(file).digest
    file.write_text(file.read_text() + '\n[model]\norder = "reduced"\nstates = "thumb.states"\n')
    setup = load_setup(file, basis="thumb.basis")
    assert isinstance(setup.robot.body, ReducedBody)
    controller = Controller(setup.robot, setup.contact)
    goal = setup.robot.effector(setup.robot.rest()) + np.array([0.003, 0.0, 0.0005])
    for _ in range(20):
        decision = controller.step(goal.ravel())
    assert decision.status.usable
    assert decision.position[0] > 5e-4


@pytest.mark.slow
def test_reduce_states_of_beams(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_short_arm(tmp_path)
    places = ("--out", tmp_path / "arm.basis", "--snapshots", tmp_path / "campaign")
    design = ("--design", "latin-hypercube", "--runs", 6, "--steps", 12, "--tension", 0, 1)
    assert run_main("reduce", file, *design, "--k", 3, "--states", *places) == 0
    said = capsys.readouterr().out
    states = StateBasis.load(tmp_path / "arm.states")
    assert (
        run_main("reduce", file, *design, "--k", 3, "--states", *places) == 0
    )  # of the kept campaign
    again = StateBasis.load(tmp_path / "arm.states")
    np.testing.assert_array_equal(again.Phi, states.Phi)
    assert f"{states.origin.sample} of 42 elements" in said
    assert states.origin.tip_max < 1e-3  # of 180 mm
    chosen = '[model]\norder = "reduced"\nstates = "arm.states"\n'
    file.write_text(file.read_text().replace("[model]\n", chosen))
    setup = load_setup(file, basis="arm.basis")
    assert isinstance(setup.robot.body, ReducedBody)
    controller = Controller(setup.robot, setup.contact)
    goal = setup.robot.effector(setup.robot.rest()) + np.array([0.01, 0.0, 0.001])
    for _ in range(20):
        decision = controller.step(goal.ravel())
    assert decision.status.usable
    assert np.abs(decision.position).max() > 5e-4
