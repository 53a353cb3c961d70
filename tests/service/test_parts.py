"""The shipped finger in a hand of three: bases of parts, decisions of parts, a demo and its replay."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.processes import forked

from tauten.controller import warm_controller
from tauten.model import one_blas_thread
from tauten.model.schema import RobotFileError
from tauten.reduction import ContactBasis
from tauten.reduction.state import StateBasisError, reducible
from tauten.service.check import CheckSettings, check_robot
from tauten.service.plant import DemoSettings, run_demo
from tauten.service.process import StopFlag
from tauten.service.replay import replay
from tauten.service.setup import load_setup

HAND = Path(__file__).resolve().parents[2] / "examples" / "hand.toml"


def test_each_finger_has_the_bases_of_the_finger_and_moves_as_it_does() -> None:
    """Self-contact, reduced states and contact modes of a part, in three places, from the part's files."""
    one, both = load_setup("finger"), load_setup(HAND)
    assert isinstance(one.contact, ContactBasis) and isinstance(both.contact, ContactBasis)
    assert (both.contact.k, both.robot.n_c) == (3 * one.contact.k, 3 * one.robot.n_c)
    assert [basis.digest() for basis in both.states] == [one.states[0].digest()] * 3
    assert both.robot.n == 3 * one.robot.n
    assert both.robot.actuators.names == ("left_tendon", "right_tendon", "back_tendon")
    finger, hand = warm_controller(one), warm_controller(both)
    rest, tips = one.robot.effector(one.robot.rest()), both.robot.effector(both.robot.rest())
    way = np.array([0.045, 0.0, 0.025])
    pushed = 0.0
    turns = Rotation.from_rotvec([[0.0, 0.0, k * 2.0 * np.pi / 3.0] for k in range(3)]).as_matrix()
    with one_blas_thread():
        for k in range(40):
            share = min(1.0, k / 30)
            alone = finger.step(rest + share * way)
            together = hand.step(tips + share * np.array([turn @ way for turn in turns]))
            assert together.status == alone.status
            np.testing.assert_allclose(together.position, np.tile(alone.position, 3), atol=1e-7)
            np.testing.assert_allclose(together.effort, np.tile(alone.effort, 3), atol=1e-5)
            pushed = max(pushed, finger.lam_c.max())
    assert pushed > 0.0
    np.testing.assert_allclose(hand.lam_c, np.tile(finger.lam_c, 3), atol=1e-5)
    forces, own = hand.contact_forces, finger.contact_forces
    turned = np.concatenate([own @ turn.T for turn in turns])
    np.testing.assert_allclose(forces, turned, atol=1e-5)
    lifted = both.reduced
    assert lifted is not None
    start = lifted.body.lifted(hand.state)
    full = lifted.body.full
    np.testing.assert_allclose(full.effector(start), hand.effector, atol=1e-9)


@pytest.mark.parametrize(("basis", "modes"), [("none", 0), ("full", 0)])
def test_contact_of_all_parts_may_be_chosen(basis: str, modes: int) -> None:
    setup = load_setup(HAND, basis=basis)
    assert setup.contact == basis
    assert setup.basis_modes == modes


@pytest.mark.parametrize(
    ("table", "unknowns"), [("check_period = 0.5", 72), ('order = "full"', 18_060)]
)
def test_the_model_of_all_parts_is_chosen_only_where_it_is_said(
    tmp_path: Path, table: str, unknowns: int
) -> None:
    path = tmp_path / "hand.toml"
    two = HAND.read_text().rsplit("[[parts]]", 1)[0]
    path.write_text(f"{two}\n[model]\n{table}\n")
    assert load_setup(path).robot.n == unknowns


@pytest.mark.parametrize("table", ['states = "finger"', "max_tip_error = 1e-9"])
def test_state_bases_of_parts_are_checked(tmp_path: Path, table: str) -> None:
    path = tmp_path / "hand.toml"
    path.write_text(f"{HAND.read_text()}\n[model]\n{table}\n")
    with pytest.raises((RobotFileError, StateBasisError), match=r"of the parts|1e-06 mm"):
        load_setup(path)


def test_state_bases_belong_to_the_parts() -> None:
    with pytest.raises(StateBasisError, match="reduce the robot file of each part"):
        reducible(load_setup(HAND, model="full").robot)


def test_a_part_that_cannot_be_used_is_named(tmp_path: Path) -> None:
    path = tmp_path / "hand.toml"
    path.write_text(HAND.read_text().replace('robot = "finger"', 'robot = "thumb.toml"'))
    with pytest.raises(RobotFileError, match=r"thumb\.toml"):
        load_setup(path)


def two_of(robot: Path, folder: Path) -> Path:
    """A robot of two parts of one file."""
    path = folder / "pair.toml"
    parts = [
        f'[[parts]]\nname = "{name}"\nrobot = "{robot}"\nposition = [0.0, {y}, 0.0]\n'
        for name, y in (("a", 0.0), ("b", 0.1))
    ]
    path.write_text("\n".join(['name = "pair"', *parts]))
    return path


def test_a_demo_of_parts_is_replayed(
    beam_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tauten.service.plant.processes._start", forked)
    path, out = two_of(beam_file, tmp_path), tmp_path / "out"
    settings = DemoSettings(str(path), out, seconds=1.0, period=2.0, fraction=0.3)
    done = run_demo(settings, StopFlag(), lambda text: None)
    assert done.actuators.names == ("a_lower", "a_upper", "b_lower", "b_upper")
    late = done.report.hindered.get("deadlines missed", 0)  # all of them on a busy machine
    assert done.report.following + late > 5
    assert replay(out / "log.mcap", 1e-4, against=str(path)).same


def test_a_check_looks_at_every_file_once(beam_file: Path, tmp_path: Path) -> None:
    path = two_of(beam_file, tmp_path)
    settings = CheckSettings(str(path), shares=())
    found = check_robot(settings, StopFlag(), lambda share, what="": None)
    assert not found.refused and found.robot == "pair"
    subjects = [item.subject for item in found.findings]
    assert f"{beam_file.with_suffix('')}: moving mass" in subjects
    assert len(set(subjects)) == len(subjects)
