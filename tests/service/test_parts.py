"""The shipped finger in a hand of three: bases of parts, decisions of parts, a demo and its replay."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.processes import forked
from support.robots.examples import shipped_setup

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


@pytest.mark.long
def test_each_finger_has_the_bases_of_the_finger_and_moves_as_it_does() -> None:
    """Self-contact, reduced states and contact modes of a part, in three places, from the part's files."""
    one, both = shipped_setup("finger"), load_setup(HAND)
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


def test_tables_of_a_part_that_do_not_count_are_named_once(
    tmp_path: Path, beam_file: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Two parts of one file: one warning for each table, none for what all parts say or the default."""
    for file in (beam_file, beam_file.with_name("beam.vtu")):
        shutil.copy(file, tmp_path)
    part = tmp_path / "beam.toml"
    text = part.read_text().replace("controller = { rate = 50.0 }", "")
    part.write_text(
        f"controller = {{ regularisation = 1e-5, horizon = 0.1, max_pivots = 100 }}\n{text}"
    )
    whole = tmp_path / "both.toml"
    parts = "".join(
        f'[[parts]]\nname = "{name}"\nrobot = "beam.toml"\nposition = [0.0, {y}, 0.0]\n'
        for name, y in (("one", 0.0), ("other", 0.1))
    )
    tables = (
        "gravity = [0.0, 0.0, 0.0]\ncontroller = { horizon = 0.3 }\nservice = { late_limit = 9 }\n"
    )
    whole.write_text(f'name = "both"\n{tables}{parts}')
    load_setup(whole)
    said = " not used; write what is to count into this file, which has the default"
    assert [record.getMessage() for record in caplog.records] == [
        f"{whole}: regularisation in the table controller of {part} is{said}",
        f"{whole}: release_time, target_timeout in the table service of {part} are{said}",
    ]


@pytest.mark.parametrize(("basis", "modes"), [("none", 0), ("full", 0)])
def test_contact_of_all_parts_may_be_chosen(tmp_path: Path, basis: str, modes: int) -> None:
    setup = load_setup(two_of("pneumatic_finger", tmp_path), basis=basis)
    assert setup.contact == basis
    assert setup.basis_modes == modes


@pytest.mark.parametrize(
    ("table", "unknowns"), [("check_period = 0.5", 106), ('order = "full"', 1482)]
)
def test_the_model_of_all_parts_is_chosen_only_where_it_is_said(
    tmp_path: Path, table: str, unknowns: int
) -> None:
    path = two_of("tripod", tmp_path)
    path.write_text(f"{path.read_text()}\n[model]\n{table}\n")
    assert load_setup(path).robot.n == unknowns


@pytest.mark.parametrize("table", ['states = "tripod"', "max_tip_error = 1e-9"])
def test_state_bases_of_parts_are_checked(tmp_path: Path, table: str) -> None:
    path = two_of("tripod", tmp_path)
    path.write_text(f"{path.read_text()}\n[model]\n{table}\n")
    with pytest.raises((RobotFileError, StateBasisError), match=r"of the parts|1e-06 mm"):
        load_setup(path)


def test_state_bases_belong_to_the_parts(tmp_path: Path) -> None:
    with pytest.raises(StateBasisError, match="reduce the robot file of each part"):
        reducible(load_setup(two_of("tripod", tmp_path), model="full").robot)


def test_a_part_that_cannot_be_used_is_named(tmp_path: Path) -> None:
    path = tmp_path / "hand.toml"
    path.write_text(HAND.read_text().replace('robot = "finger"', 'robot = "thumb.toml"'))
    with pytest.raises(RobotFileError, match=r"thumb\.toml"):
        load_setup(path)


def two_of(robot: Path | str, folder: Path) -> Path:
    """A robot of two parts of one file."""
    path = folder / "pair.toml"
    parts = [
        f'[[parts]]\nname = "{name}"\nrobot = "{robot}"\nposition = [0.0, {y}, 0.0]\n'
        for name, y in (("a", 0.0), ("b", 0.1))
    ]
    path.write_text("\n".join(['name = "pair"', *parts]))
    return path


@pytest.mark.long
def test_a_demo_of_parts_is_replayed(
    beam_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tauten.service.plant.processes._start", forked)
    path, out = two_of(beam_file, tmp_path), tmp_path / "out"
    settings = DemoSettings(str(path), out, seconds=1.0, period=2.0, fraction=0.3)
    done = run_demo(settings, StopFlag(), lambda text: None)
    assert done.actuators.names == ("a_lower", "a_upper", "b_lower", "b_upper")
    late = done.report.hindered.get("deadlines missed", 0)  # all of them on a busy machine
    assert done.report.following + late > 0.5 * done.report.ticks > 1.0  # which is slowed there
    assert replay(out / "log.mcap", 1e-4, against=str(path)).same


@pytest.mark.long
def test_a_check_looks_at_every_file_once(beam_file: Path, tmp_path: Path) -> None:
    path = two_of(beam_file, tmp_path)
    settings = CheckSettings(str(path), shares=())
    found = check_robot(settings, StopFlag(), lambda share, what="": None)
    assert not found.refused and found.robot == "pair"
    subjects = [item.subject for item in found.findings]
    assert f"{beam_file.with_suffix('')}: moving mass" in subjects
    assert len(set(subjects)) == len(subjects)


def test_a_rigid_object_needs_no_state_basis(tmp_path: Path) -> None:
    for name in ("parcel.toml", "cube.vtu"):
        (tmp_path / name).write_bytes(HAND.with_name(name).read_bytes())
    file = tmp_path / "desk.toml"
    parts = '[[parts]]\nname = "arm"\nrobot = "tripod"\n[[parts]]\nname = "parcel"\nrobot = "parcel.toml"\n'
    file.write_text(f'name = "desk"\n{parts}position = [0.2, 0.0, 0.0]\n')
    desk = load_setup(file, model="reduced")
    (states,) = desk.states
    assert (states.origin.robot, desk.robot.n) == ("tripod", states.r + 6)
