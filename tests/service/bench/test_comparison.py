"""`tauten compare`: contact keeps bodies apart that pass through each other without it."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.processes import run_main
from support.robots.thumb import write_thumb

from tauten.model import Robot, Simulator
from tauten.model.simulation import Ending
from tauten.service.bench import CompareError, compare_equilibria, equilibrium


@pytest.mark.long
def test_contact_opens_what_overlaps(finger: Robot) -> None:
    position = finger.limits.position_max
    passing, touching = (equilibrium(finger, kind, position, None) for kind in ("none", "full"))
    found = compare_equilibria(finger, touching, passing)
    assert found.deepest_overlap_mm > 0.5
    assert finger.rows(touching.state).contacts.rows.delta.min() > -1e-5
    assert found.pushing > 20
    assert found.apart_mm[0] == pytest.approx(
        1e3 * np.linalg.norm(touching.effector - passing.effector), rel=1e-12
    )
    # both are wound to the same length; who has to be squeezed needs more tension for it
    np.testing.assert_allclose(found.pull_mm, 25.0, rtol=1e-6)
    assert found.tension_n[0][0] > 1.5 * found.tension_n[1][0]


@pytest.mark.parametrize(
    ("contact", "sentence"),
    [
        (
            "none",
            "without contact: the state has diverged; what nothing but contact holds has none$",
        ),
        ("full", "with contact: the state has diverged$"),
    ],
)
def test_no_equilibrium_at_all_is_a_sentence(
    contact: str, sentence: str, finger: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    lost = SimpleNamespace(share=0.0, converged=False, ending=Ending.NOT_FINITE)
    monkeypatch.setattr(Simulator, "settle", lambda *_, **__: lost)
    with pytest.raises(CompareError, match=f"finger: found no equilibrium {sentence}"):
        equilibrium(finger, contact, finger.limits.position_max, None)


@pytest.mark.slow
def test_a_robot_that_only_contact_holds_has_no_equilibrium_without_it(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    robot = Path(__file__).parents[3] / "examples" / "crawler.toml"
    assert run_main("compare", robot, "--figure", tmp_path / "crawler.png") == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "crawler: found no equilibrium without contact: the steps do not become small" in said
    assert said.endswith("what nothing but contact holds has none")


@pytest.mark.slow
def test_a_load_without_equilibrium_is_shortened(finger: Robot) -> None:
    position = np.array([0.5])  # m, four times the length of the finger
    passing = equilibrium(finger, "none", position, None)
    assert 0.0 < passing.share < 1.0
    assert passing.position[0] == pytest.approx(passing.share * position[0], abs=1e-6)
    assert compare_equilibria(finger, passing, passing).share == (passing.share, passing.share)


@pytest.mark.long
def test_command_draws_and_writes(tmp_path: Path) -> None:
    picture, numbers = tmp_path / "finger.png", tmp_path / "finger.json"
    code = run_main(
        "compare",
        write_thumb(tmp_path),
        "--tension",
        1.0,
        "--figure",
        picture,
        "--json",
        numbers,
        "--axes",
        "xz",
    )
    assert code == 0
    assert picture.stat().st_size > 10_000
    assert json.loads(numbers.read_text())["tension_n"] == [[1.0], [1.0]]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--pull", "0.5"), "allowed are 0 to"),
        (("--pull", "0.01", "--pull", "0.01"), "thumb needs one for each actuator: 1"),
        (("--axes", "xx"), "two different ones"),
        (("--pull", "0.01", "--tension", "1"), "not both"),
    ],
)
def test_bad_options_are_refused(
    options: tuple[str, ...], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    thumb = write_thumb(tmp_path)
    assert run_main("compare", thumb, "--figure", tmp_path / "no.png", *options) == 2
    assert message in " ".join(capsys.readouterr().err.replace("│", " ").split())
    assert not list(tmp_path.glob("*.png"))
