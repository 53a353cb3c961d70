"""`tauten reduce` and `tauten inspect`: what they make, and one sentence for all that cannot be."""

from __future__ import annotations

import dataclasses
import re
import shutil
import time
from pathlib import Path

import numpy as np
import pytest
from support.processes import START, run_main, start
from support.robots.examples import EXAMPLES
from support.robots.hanging import hanging_beam
from support.robots.thumb import write_thumb

from tauten.controller import Controller
from tauten.model import load_robot
from tauten.model.schema import read_toml
from tauten.reduction import ContactBasis
from tauten.reduction.campaign import Ranges, Snapshots
from tauten.service.cli.campaigns import Campaigns, Workers, expected
from tauten.service.tables.basis import ranges

STEP = ("--design", "ramp", "--step", 4e-4)
TOLERANCE = 5e-4  # m, which a basis of so few equilibria meets


@dataclasses.dataclass
class Made:
    """What `tauten reduce` left: robot file, basis, folder of the campaign."""

    robot: Path
    basis: Path
    campaign: Path


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Made:
    folder = tmp_path_factory.mktemp("thumb")
    made = Made(write_thumb(folder), folder / "thumb.basis", folder / "campaign")
    arguments = ("reduce", made.robot, "--out", made.basis, "--snapshots", made.campaign, *STEP)
    assert run_main(*arguments, "--tolerance", TOLERANCE, "--curve", folder / "curve.png") == 0
    assert (folder / "curve.png").read_bytes().startswith(b"\x89PNG")
    return made


@pytest.fixture
def made(original: Made, tmp_path: Path) -> Made:
    """A copy that a test may spoil."""
    folder = tmp_path / "thumb"
    shutil.copytree(original.robot.parent, folder)
    return Made(folder / "thumb.toml", folder / "thumb.basis", folder / "campaign")


def refused(capsys: pytest.CaptureFixture[str], made: Made, *arguments: object) -> str:
    """The sentence with which a command ends that must not touch the basis."""
    before = made.basis.read_bytes()
    capsys.readouterr()
    assert run_main(*arguments) == 2
    assert made.basis.read_bytes() == before
    said = capsys.readouterr().err.strip().splitlines()
    sentences = [line for line in said if line.startswith("tauten: ")]
    assert len(sentences) == 1
    assert said[-1] == sentences[0]
    return sentences[0]


def again(made: Made, *more: object) -> tuple[object, ...]:
    """The command that made the basis, with other options."""
    return ("reduce", made.robot, "--out", made.basis, "--snapshots", made.campaign, *STEP, *more)


def test_automatic_basis_records_how_it_was_chosen(original: Made) -> None:
    basis = ContactBasis.load(original.basis)
    tip = {point.k: point.tip for point in basis.provenance.curve}
    assert tip[basis.k] <= TOLERANCE
    assert basis.provenance.snapshots >= 19  # of 20


@pytest.mark.long
def test_inspect_prints_where_it_comes_from_and_what_it_misses(
    original: Made, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    modes, curve = tmp_path / "modes.png", tmp_path / "curve.png"
    arguments = ("--figure", modes, "--curve", curve)  # the robot file lies beside the basis
    assert run_main("inspect", original.basis, *arguments) == 0
    text = capsys.readouterr().out
    basis = ContactBasis.load(original.basis)
    digest = re.search(r"robot digest *│ (\w+) *│\n│ *│ (\w+)", text)
    assert digest is not None
    assert "".join(digest.groups()) == basis.provenance.robot_digest
    assert re.search(rf"tip error *│ {1e3 * basis.provenance.tip_error:.3g} mm ", text)
    assert "None" not in text  # of what nobody computed
    row = next(line for line in text.splitlines() if re.search(r"│ all ", line))
    assert re.findall(r"\d+", row) == [str(basis.k), "48", str(len(basis.untouched()))]
    assert "notch1_below" in text
    assert "held out" in text
    for picture in (modes, curve):
        assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_robot_file_and_a_link_to_it_find_the_same_basis(made: Made, tmp_path: Path) -> None:
    """The basis was written beside the link, and the robot file named one that it did not find."""
    link = tmp_path / "here" / made.robot.name
    link.parent.mkdir()
    link.symlink_to(made.robot)
    mesh = Path(read_toml(made.robot)["mesh"]["file"])
    (link.parent / mesh).symlink_to(made.robot.parent / mesh)
    table = made.robot.read_text().replace(
        "controller = {rate = 50.0}", "[controller]\nrate = 50.0"
    )
    made.robot.write_text(table)
    made.basis.unlink()
    options = ("--snapshots", made.campaign, *STEP, "--tolerance", TOLERANCE, "--write")
    assert run_main("reduce", link, *options) == 0
    assert sorted(link.parent.iterdir()) == sorted([link, link.parent / mesh])
    k = ContactBasis.load(made.basis).k
    assert [Controller.of(file).space.k for file in (link, made.robot)] == [k, k]


@pytest.mark.parametrize(
    ("seconds", "workers", "said"),
    [
        (0.25, 2, "334 equilibria of about 0.25 s each, 2 at a time: about 42 s"),
        (30.0, 2, "334 equilibria of about 30 s each, 2 at a time: about 1.4 h; shorter: less"),
        (
            3.0,
            None,
            "334 equilibria of about 3 s each, divided by the workers of the cluster: about 17 min",
        ),
    ],
)
def test_a_campaign_says_how_long_it_takes(seconds: float, workers: int | None, said: str) -> None:
    assert expected(334, seconds, workers, "less").startswith(said)


def test_how_long_a_campaign_takes_is_said_before_it_begins(
    made: Made, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of three fingers as parts it took hours, of which nobody was told; what is done is not counted."""
    options = (*STEP, "--tolerance", TOLERANCE, "--out", tmp_path / "new.basis", "--workers", 1)
    assert run_main("reduce", made.robot, *options, "--snapshots", tmp_path / "new") == 0
    folder, said = capsys.readouterr().err.splitlines()[0].split(": ", 1)
    assert folder == str(tmp_path / "new")
    assert re.fullmatch(r"20 equilibria of about \S+ s each, 1 at a time: about \S+ (s|min)", said)
    assert run_main("reduce", made.robot, *options, "--snapshots", tmp_path / "new") == 0
    assert "equilibria of about" not in capsys.readouterr().err


def test_each_campaign_of_a_narrower_range_says_how_long_it_takes(
    made: Made, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Only the first one was announced, and what was announced took up to three times as long."""
    one = load_robot(made.robot), None, "ramp", 2e-3, Ranges(), 1, 1, 0, tmp_path / "new"
    campaigns = Campaigns(*one, Workers(None, 1))
    within = campaigns.narrower(campaigns.whole())
    assert within is not None
    within(0.5, lambda share, what: None)
    begun = [line.partition(": ")[0] for line in capsys.readouterr().err.splitlines()]
    assert begun == [str(tmp_path / "new"), str(tmp_path / "new" / "within-50")]


def test_a_robot_of_parts_is_told_of_the_bases_of_its_parts(tmp_path: Path) -> None:
    grasp = load_robot(EXAMPLES / "grasp.toml")
    whole, one = (
        Campaigns(robot, None, "ramp", 1e-4, Ranges(), 1, 1, 0, tmp_path, Workers(None, None))
        for robot in (grasp, grasp.body.part_robots[0])
    )
    assert whole.shorter().startswith("tauten reduce with the robot file of each part")
    assert one.shorter() == "a longer --step"


def test_inspect_without_the_robot_names_the_slots(
    made: Made, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    elsewhere = made.basis.rename(tmp_path / "thumb.basis")
    assert run_main("inspect", elsewhere) == 0
    text = capsys.readouterr().out
    untouched = ContactBasis.load(elsewhere).untouched()
    assert ranges(untouched[:3]).split(",")[0] in text
    assert "notch1_below" not in text
    assert run_main("inspect", elsewhere, "--robot", made.robot) == 0
    assert "notch1_below" in capsys.readouterr().out


def test_inspect_says_why_a_robot_file_beside_the_basis_cannot_be_used(
    made: Made, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    """The table of coverage is then that of slots, as without a robot."""
    made.robot.write_text("name = 3\n")
    assert run_main("inspect", made.basis) == 0
    assert "notch1_below" not in capsys.readouterr().out
    assert [note.getMessage()[: len(str(made.robot))] for note in caplog.records] == [
        str(made.robot)
    ]


@pytest.mark.long
def test_inspect_takes_the_shipped_robot_where_the_file_beside_does_not_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    ContactBasis.load("finger").save(tmp_path / "finger.basis")
    (tmp_path / "finger.toml").write_text("name = 3\n")
    assert run_main("inspect", tmp_path / "finger.basis") == 0
    assert load_robot("finger").pairs[0].name.split()[0] in capsys.readouterr().out
    assert not caplog.records


def test_slots_are_named_as_ranges() -> None:
    assert ranges([]) == ""
    assert ranges([0, 1, 2, 4, 6, 7]) == "0-2, 4, 6-7"
    assert ranges(list(range(0, 100, 2))).endswith("14, ...")


@pytest.mark.long
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--k", "1000"), "k = 1000 modes requested, but the snapshots have rank"),
        (("--k", "0"), "k is 0: allowed are 1 and more, and auto"),
        (("--k", "many"), "k is 'many': allowed are 1 and more, and auto"),
        (("--method", "svd"), "method 'svd' is unknown: choose one of energy, hals,"),
        (("--weighting", "none"), "weighting 'none' is unknown"),
        (("--tolerance", "1e-9"), "has a held-out effector error within 1e-06 mm"),
        (("--design", "spiral"), "no design 'spiral': allowed are exploring, ramp,"),
        (("--step", "-1"), "ramp step is -1.0 m"),
        (
            ("--touched", "skin"),
            "--touched and --touched-points need --states and the design exploring",
        ),
        (
            ("--states", "--design", "exploring", "--touched", "nail"),
            "surface 'nail' is not defined",
        ),
        (("--out", "thumb.txt"), "thumb.txt: a contact basis file ends in .basis"),
        (("--scheduler", "nonsense"), "tauten: "),
        (("--step", "2e-4"), "holds another campaign (ramp: "),
    ],
)
def test_reduce_refuses(
    made: Made, capsys: pytest.CaptureFixture[str], options: tuple[str, str], message: str
) -> None:
    assert message in refused(capsys, made, *again(made, *options))


@pytest.mark.long
def test_a_robot_file_that_was_edited_is_told_what_to_do_with_its_snapshots(
    made: Made, capsys: pytest.CaptureFixture[str]
) -> None:
    text = made.robot.read_text()
    stiffer = re.sub(r"young_modulus = [^,}\n]+", "young_modulus = 2e5", text)
    assert stiffer != text
    made.robot.write_text(stiffer)
    sentence = refused(capsys, made, *again(made))
    assert sentence == (
        f"tauten: {made.campaign}: holds another campaign (made before the model in the robot file or its "
        "mesh was changed): delete this folder, or choose another with --snapshots"
    )
    (made.robot.parent / "again").mkdir()
    command = list(again(made, "--tolerance", TOLERANCE))
    command[command.index("--out") : command.index("--snapshots") + 2] = [
        "--snapshots", made.robot.parent / "again",
    ]  # fmt: skip
    before = made.basis.read_bytes()
    assert run_main(*command) == 0
    assert made.basis.read_bytes() != before  # beside the robot file, where it is looked for


@pytest.mark.slow
def test_contacts_with_friction_in_all_of_them_get_no_contact_basis(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No step would use it, and its modes may fail for the state basis that is asked for."""
    robot = write_thumb(tmp_path)
    text = robot.read_text()
    assert text.count("points = 24}") == 2
    robot.write_text(text.replace("points = 24}", "points = 24, friction = 0.4}"))
    arguments = ("reduce", robot, "--out", tmp_path / "thumb.basis", "--states", "--accept-error")
    ramp = ("--design", "ramp", "--step", 1e-3, "--snapshots", tmp_path / "campaign")
    assert run_main(*arguments, *ramp) == 0
    assert (tmp_path / "thumb.states").exists()
    assert not (tmp_path / "thumb.basis").exists()
    assert "basis = " not in capsys.readouterr().out


PAIR = """name = "pair"
[[parts]]
name = "low"
robot = "beam.toml"
[[parts]]
name = "high"
robot = "beam.toml"
position = [0.0, 0.0, 0.0215]
[[contacts]]
candidates = { part = "low" }
against = { part = "high" }
spacing = 0.01
[controller]
rate = 20.0
"""


@pytest.mark.long
def test_a_robot_of_parts_has_modes_of_the_contact_between_them(tmp_path: Path) -> None:
    """As docs/parts.md says."""
    hanging_beam(tmp_path, more="[integration]\nrayleigh_stiffness = 0.02\n")
    file = tmp_path / "pair.toml"
    file.write_text(PAIR, encoding="utf-8")
    campaign = tmp_path / "campaign"
    wanted = (
        "--design",
        "ramp",
        "--step",
        4e-3,
        "--snapshots",
        campaign,
        "--workers",
        1,
        "--write",
    )
    assert run_main("reduce", file, *wanted) == 0
    controller, basis = Controller.of(file), ContactBasis.load(tmp_path / "pair.basis")
    target = controller.effector + np.array([[0.0, 0.0, 0.003], [0.0, 0.0, 0.0]])
    statuses = [controller.step(target).status.name for _ in range(10)]
    assert statuses == ["OK"] * 10
    by_modes = basis.Psi @ controller.forces.beta  # (n_c,) N
    assert by_modes.sum() > 0.5 * controller.contacts.normal_force.sum() > 0.0


def test_snapshots_without_contact_make_no_basis(
    made: Made, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    loads = tmp_path / "loads.csv"
    loads.write_text("run,pull_tendon\n0,0.0001\n0,0.0002\n")
    options = ("--design", loads, "--snapshots", tmp_path / "light")
    sentence = refused(capsys, made, *again(made, *options))
    assert "none of the 2 snapshots has any contact force" in sentence


def test_nan_in_the_snapshots_is_named(made: Made, capsys: pytest.CaptureFixture[str]) -> None:
    (file,) = made.campaign.iterdir()
    snapshots = Snapshots.load(file)
    lam = snapshots.lam.copy()
    lam[3, 17] = np.nan
    dataclasses.replace(snapshots, lam=lam).save(file)
    assert "NaN or infinite forces in column 17" in refused(capsys, made, *again(made))


def test_damaged_snapshots_are_named(made: Made, capsys: pytest.CaptureFixture[str]) -> None:
    (file,) = made.campaign.iterdir()
    file.write_bytes(file.read_bytes()[:-100])
    assert f"{file}: this is no readable" in refused(capsys, made, *again(made))


def test_damaged_basis_is_named(made: Made, capsys: pytest.CaptureFixture[str]) -> None:
    made.basis.write_bytes(made.basis.read_bytes()[:-100])
    assert f"{made.basis}: this is no readable" in refused(capsys, made, "inspect", made.basis)


@pytest.mark.long
def test_basis_of_another_robot_is_not_drawn(
    made: Made, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    picture = tmp_path / "modes.png"
    arguments = ("inspect", made.basis, "--robot", "finger", "--figure", picture)
    assert "made for robot 'thumb'" in refused(capsys, made, *arguments)
    assert not picture.exists()


@pytest.mark.long
def test_interrupted_campaign_goes_on(tmp_path: Path) -> None:
    robot, loads = write_thumb(tmp_path), tmp_path / "loads.csv"
    lines = [
        f"{run},{(4.0 - 0.1 * run) * 1e-4 * step}" for run in range(2) for step in range(1, 21)
    ]
    loads.write_text("\n".join(["run,pull_tendon", *lines]))
    folder = tmp_path / "cut"
    command = ("reduce", robot, "--k", 3, "--design", loads, "--snapshots", folder, "--workers", 1)
    process = start(tmp_path / "output.txt", *command, "--out", tmp_path / "cut.basis")
    end = time.monotonic() + START
    first = folder / "run0000-000000.snapshots"
    while not first.exists():
        assert process.process.poll() is None, process.output.read_text()
        assert time.monotonic() < end
        time.sleep(0.02)
    assert process.end() == 130
    assert "cut keeps the finished part" in process.output.read_text().replace("\n", "")
    assert not (tmp_path / "cut.basis").exists()
    written = first.stat().st_mtime_ns
    assert run_main(*command, "--out", tmp_path / "cut.basis") == 0
    assert first.stat().st_mtime_ns == written
    converged = ContactBasis.load(tmp_path / "cut.basis").provenance.snapshots
    assert 36 <= converged <= 40
