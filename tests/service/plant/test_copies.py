"""Copies of a robot's files in the folder of its demo: nothing of the user is replaced, none is mixed up."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from support.processes import run_main

from tauten.model import RobotFileError, load_robot
from tauten.service.plant.copying import robot_copies, write_copies
from tauten.service.plant.demo import LOG, TARGETS
from tauten.service.plant.processes import Child, DemoError


def contents(folder: Path) -> dict[str, bytes]:
    """All files below a folder."""
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("name", ["beam.toml", "beam.vtu", TARGETS, LOG])
def test_files_of_the_user_stay(
    beam_file: Path, tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_text("mine")
    assert run_main("demo", beam_file, "--path", "line", "--seconds", 1, "--out", tmp_path) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "choose another --out" in said and name in said.replace(" ", "")
    assert contents(tmp_path) == {str(tmp_path / name): b"mine"}


def test_targets_that_are_given_stay(
    beam_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where a demo has been before."""
    (tmp_path / "serve.txt").write_text("")
    file = tmp_path / TARGETS
    file.write_text("t,x,y,z\n0,0.1,0.01,0.01\n1,0.1,0.01,0.01\n")
    before = contents(tmp_path)
    assert run_main("demo", beam_file, "--path", file, "--seconds", 1, "--out", tmp_path) == 2
    assert "the demo would replace it" in " ".join(capsys.readouterr().err.split())
    assert contents(tmp_path) == before


def test_copies_that_are_there_are_none_in_the_way(beam_file: Path, tmp_path: Path) -> None:
    write_copies(copies := robot_copies(beam_file, None, tmp_path))
    assert {path.name for path in copies} >= {"beam.toml", "beam.vtu"}
    assert robot_copies(beam_file, None, tmp_path) == copies
    assert robot_copies(beam_file, None, beam_file.parent) == {}


ROBOT = """\
name = "pair"
parts = [
    {{ name = "p", robot = '{first}' }},  # it's '../mine', not "{second}"
    {{ name = "q", robot = "{second}" }},
]
controller = {{ basis = \'../bases/chosen\' }}
"""


def files(folder: Path, **names: str) -> Path:
    """A robot file in `folder`/robot whose parts name meshes of the same name."""
    for place in ("a", "b", "bases", "robot"):
        (folder / place).mkdir(parents=True)
    for place in ("a", "b"):
        (folder / place / "body.toml").write_text(
            'mesh = { file = "../meshes/' + place + '/m.vtu" }'
        )
        (mesh := folder / "meshes" / place / "m.vtu").parent.mkdir(parents=True)
        mesh.write_text(place)
    (folder / "bases/chosen.basis").write_text("basis")
    robot = folder / "robot" / "pair.toml"
    robot.write_text(
        ROBOT.format(first="../a/body.toml", second="../b/body") + names.get("more", "")
    )
    return robot


def test_equal_names_from_elsewhere_stay_apart(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write_copies(robot_copies(files(tmp_path / "from"), None, out))
    copied = tomllib.loads((out / "pair.toml").read_text())
    for part, expected in zip(copied["parts"], "ab", strict=True):
        file = (out / part["robot"]).with_suffix(".toml")
        mesh = file.parent / tomllib.loads(file.read_text())["mesh"]["file"]
        assert out in mesh.resolve().parents
        assert mesh.read_text() == expected
    assert (out / copied["controller"]["basis"]).with_suffix(".basis").read_text() == "basis"
    assert (out / "chosen.basis").read_text() == "basis"  # where a log looks for it
    assert "# it's '../mine'" in (out / "pair.toml").read_text()


def test_two_files_for_one_copy_are_refused(tmp_path: Path) -> None:
    robot = files(tmp_path / "from")
    (robot.parent / "chosen.basis").write_text("another")
    robot.write_text(robot.read_text().replace("pair", "chosen"))
    robot = robot.rename(robot.with_name("chosen.toml"))
    with pytest.raises(RobotFileError, match="rename one"):
        robot_copies(robot, None, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_copied_robot_with_a_mesh_from_elsewhere_loads(beam_file: Path, tmp_path: Path) -> None:
    (folder := tmp_path / "robot").mkdir()
    robot = folder / "beam.toml"
    robot.write_text(
        beam_file.read_text().replace('"beam.vtu"', f"'{beam_file.with_suffix('.vtu')}'")
    )
    write_copies(robot_copies(robot, None, tmp_path / "out"))
    assert str(beam_file.parent) not in (tmp_path / "out/beam.toml").read_text()
    assert load_robot(tmp_path / "out/beam.toml").n == load_robot(robot).n


def test_a_process_that_ctrl_c_ended_has_not_failed(tmp_path: Path) -> None:
    """In a terminal Ctrl-C reaches every process of it, so that a child may end first."""
    code = "import time; print('ready', flush=True); time.sleep(60)"
    (output := tmp_path / "child.txt").write_text("Traceback")
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as process:
        child = Child("serve", process, output)
        assert process.stdout is not None and process.stdout.readline() == b"ready\n"
        child.check()
        process.send_signal(signal.SIGINT)
        process.wait(10)
        child.check()
    with subprocess.Popen([sys.executable, "-c", "raise SystemExit(3)"]) as process:
        process.wait(10)
        with pytest.raises(DemoError, match="ended with 3: Traceback"):
            Child("serve", process, output).check()


def test_a_full_disk_is_named_and_leaves_no_part_of_a_copy(tmp_path: Path) -> None:
    """No file was named, and half of a robot file was left, for which the next demo refused the folder."""
    target, usual = tmp_path / "demo" / "beam.toml", resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(
        resource.RLIMIT_FSIZE, (100, usual[1])
    )  # of each file, as a disk that is full
    try:
        with pytest.raises(OSError, match="large") as caught:
            write_copies({target: bytes(1000)})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)
    assert caught.value.filename == str(target)
    assert not list(target.parent.iterdir())
