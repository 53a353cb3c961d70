"""The command line: errors are one sentence and exit 2; replay's exit code is its verdict."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
import typer
from rich.text import Text
from support.nodes import wait_mode
from support.processes import ROBOT, START, Served, run_main, start, write_robot

from benchmarks.commands import app as benchmarks
from tauten.model.numerics import FactorisationError
from tauten.service.cli import entry
from tauten.service.cli.app import app
from tauten.service.cli.terminal import show_result
from tauten.service.parent import PARENT
from tauten.service.plant import PathError, PathSettings, find_receiver, free_ports, receiver_path
from tauten.service.process import StopFlag
from tauten.service.tables import Numbers, Page
from tauten.service.wire import Mode, Network, Role, session_of


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_main("--help") == 0
    said = capsys.readouterr().out
    commands = "serve plant stream demo replay command record metrics contacts alive doctor"
    commands += " reduce inspect compare check new bench"
    for command in commands.split():
        assert re.search(rf"\b{command}\b", said)


def test_the_version_is_that_which_is_installed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_main("--version") == 0
    assert capsys.readouterr().out == f"tauten {version('tauten')}\n"


def test_a_benchmark_that_is_not_in_the_package_is_said_to_be_in_a_clone(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run_main("bench", "friction", "--json", "friction.json") == 2
    said = " ".join(capsys.readouterr().err.replace("│", " ").split())
    assert "allowed are steps, node, closed-loop, reduced" in said
    assert "python -m benchmarks friction" in said


@pytest.mark.parametrize("number", ["", "soon", "-1"])
def test_a_parent_that_is_none_is_ignored(number: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert entry.PARENT == PARENT
    monkeypatch.setenv(PARENT, number)
    assert run_main("--version") == 0


LOADED = """
import json
import sys
from tauten.service.cli import main
for words in json.loads(sys.argv[1]):
    sys.argv = ["tauten", *words]
    try:
        main()
    except SystemExit as ended:
        print("code", ended.code, file=sys.stderr)
print(*sys.modules, file=sys.stderr)
"""
OF_A_MODEL = {"numpy", "scipy", "numba", "matplotlib", "osqp", "qpsolvers", "viser"}
OF_A_MODEL |= {"daqp", "proxsuite", "meshio", "rosbags", "mcap", "prometheus_client"}


def test_what_a_terminal_has_no_characters_for_is_printed_all_the_same() -> None:
    """`tauten check` ended in a traceback of Python where the terminal's encoding has no arrow."""
    program = "from tauten.service.cli.entry import run; run(lambda: print('wall \u2192 thicker'))"
    environment = os.environ | {"PYTHONIOENCODING": "latin-1"}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, env=environment, capture_output=True, check=True)
    assert done.stdout == b"wall ? thicker\n"


def loaded_by(*commands: tuple[str, ...]) -> tuple[list[str], list[str]]:
    """Exit codes of commands that one new interpreter runs, and the modules it has loaded at the end."""
    done = subprocess.run(
        [sys.executable, "-c", LOADED, json.dumps(commands)],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    *said, modules = done.stderr.strip().splitlines()
    assert "Traceback" not in done.stderr
    return [line.split()[1] for line in said if line.startswith("code ")], modules.split()


def test_help_waits_for_nothing_that_a_model_needs() -> None:
    helps = [(name, "--help") for name in ("view", "reduce", "bench")]
    codes, loaded = loaded_by(("--help",), ("--version",), *helps)
    assert codes == ["0"] * 5
    assert not OF_A_MODEL & {name.partition(".")[0] for name in loaded}
    assert not [name for name in loaded if name.startswith(("tauten.model", "tauten.controller"))]


@pytest.mark.long
def test_what_an_operator_asks_a_node_needs_no_model(shared: Served) -> None:
    """`alive` is the measure: the others load messages besides, and nothing of the model."""
    words = {"lock": ("lower", "--position", "0"), "unlock": ("lower",)}
    asked = ("alive", "lock", "unlock", "metrics", "contacts")
    port = ("--port", str(shared.port))
    codes, loaded = loaded_by(*((one, "beam", *words.get(one, ()), *port) for one in asked))
    assert len(codes) == len(asked)
    assert "tauten.service.link" in loaded
    assert not {"scipy", "numba", "daqp", "meshio", "mcap"} & set(loaded)
    assert not [name for name in loaded if name.startswith(("tauten.model", "tauten.controller"))]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("serve", "nobody"), "no robot 'nobody'"),
        (("plant", "none.toml"), "none.toml: cannot be read"),
        (("stream", "square", "--robot", "trunk"), "no path 'square'"),
        (
            ("stream", "circle", "--robot", "trunk", "--effector", "toe"),
            "trunk has no effector 'toe', it has tip",
        ),
        (("replay", "none.mcap"), "none.mcap: cannot be read"),
        (("inspect", "none.basis"), "none.basis: "),
        (("reduce", "tripod", "--design", "none.csv"), "none.csv"),
    ],
)
def test_errors_are_a_sentence(
    arguments: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_main("--log-level", "error", *arguments) == 2
    said = capsys.readouterr()
    assert said.out == ""
    lines = said.err.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("tauten: ")
    assert message in lines[0]


def test_a_robot_file_is_viewed_with_simulate_or_by_its_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_main("view", write_robot(tmp_path)) == 2
    said = " ".join(capsys.readouterr().err.replace("│", " ").split())
    assert "add --simulate, or where it is served: tauten view beam" in said


@pytest.mark.long
def test_bad_input_is_exit_code_2_also_where_nothing_can_be_said() -> None:
    """It was 1, which is a finding, where the disk was full that stderr goes to."""
    words = ["-m", "tauten.service", "inspect", "nothing"]
    with Path("/dev/full").open("w") as full:
        assert subprocess.run([sys.executable, *words], stderr=full, check=False).returncode == 2


def test_a_folder_that_cannot_be_made_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write_robot(tmp_path)
    for out in ("/dev/full", file):
        assert run_main("--log-level", "error", "demo", file, "--out", out) == 2
        assert capsys.readouterr().err == f"tauten: {out}: exists and is no folder\n"


@pytest.mark.parametrize(
    "command",
    [
        ("inspect", "finger", "--figure"),
        ("compare", "finger", "--figure"),
        ("check", "finger", "--regions"),
    ],
)
def test_a_picture_of_no_kind_is_refused_before_anything_is_computed(
    command: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It ended in a traceback after all of it; without an ending another file was written than it said."""
    for name, message in (("a.txt", "ends with one of ."), ("a", ".svg"), ("", "is a folder")):
        assert run_main(*command, tmp_path / name) == 2
        assert message in " ".join(re.sub("[│\n]", " ", capsys.readouterr().err).split())
    assert list(tmp_path.iterdir()) == []


def test_a_plant_says_at_once_that_its_port_is_taken(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not after it has got ready, which takes up to a minute."""
    monkeypatch.setattr("tauten.service.plant.plant.plant_setup", None)
    file, port = write_robot(tmp_path), free_ports()
    with session_of(Network(port), Role.PLANT, "bar"):
        assert run_main("--log-level", "error", "plant", file, "--port", port) == 2
    assert f"tauten: port {port + 1} on 127.0.0.1 is taken" in capsys.readouterr().err


def helps(command: Any) -> Iterator[str]:
    """Texts of the help of a command and of those in it."""
    yield command.help or ""
    yield from (getattr(option, "help", None) or "" for option in command.params)
    for inner in getattr(command, "commands", {}).values():
        yield from helps(inner)


def test_the_help_has_nothing_that_the_terminal_takes_for_markup() -> None:
    """Units in brackets were left out: "Duration of one pass ."."""
    for program in (app, benchmarks):
        found = list(helps(typer.main.get_command(program)))
        assert len(found) > 30
        for text in found:
            assert Text.from_markup(text).plain == text


def test_tables_and_paths_are_shown_as_they_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    numbers = Numbers("[bold]", ("path", "tip [mm]", "[s]"), (("[/x]", "1", "2"),))
    show_result({}, Page("x", "about [mm]", (numbers, "from [a] to [/b]")), None)
    said = capsys.readouterr().out
    for text in ("[bold]", "tip [mm]", " [s]", "[/x]", "about [mm]", "from [a] to [/b]"):
        assert text in said
    assert "\\" not in said
    shutil.copy(files("tauten.model.robots") / "finger.states", tmp_path / "[mm].states")
    monkeypatch.chdir(tmp_path)
    assert run_main("inspect", "[mm].states") == 0
    assert " [mm].states" in capsys.readouterr().out


def test_a_motion_that_diverges_is_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Which factorisation ends so, and at which rate, depends on the machine: the error is put in."""

    def diverged(*_: object) -> None:
        raise FactorisationError("not positive definite, PARDISO error -4 in phase 22")

    monkeypatch.setattr("tauten.service.check.check_robot", diverged)
    assert run_main("--log-level", "error", "check", write_robot(tmp_path)) == 2
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert said.startswith("tauten: the simulated motion has diverged")
    assert "PARDISO error -4 in phase 22); choose a larger controller.rate" in said


def test_a_bad_robot_file_names_file_and_field(tmp_path: Path) -> None:
    """As a process: the exit code is the operating system's."""
    file = write_robot(tmp_path, ROBOT.replace("rate = 50.0", "rate = -1.0"))
    serve = start(tmp_path / "serve.txt", "--log-level", "error", "serve", file)
    assert serve.process.wait(START) == 2
    (line,) = serve.output.read_text().splitlines()
    assert line.startswith(f"tauten: {file}: controller.rate: ")


def test_a_log_that_cannot_be_made_is_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    robot = write_robot(tmp_path)
    log = tmp_path / "file" / "log.mcap"
    assert run_main("--log-level", "error", "serve", robot, "--record", log) == 2
    said = capsys.readouterr().err
    assert said.startswith("tauten: ")
    assert len(said.strip().splitlines()) == 1


@pytest.mark.long
def test_targets_of_a_served_robot_need_no_robot_file(served: Served, tmp_path: Path) -> None:
    arguments = ("--robot", "beam", "--port", served.port, "--duration", 60.0)
    stream = start(tmp_path / "stream.txt", "stream", "line", "--size", 0.004, *arguments)
    wait_mode(served, Mode.RUN)
    stream.process.send_signal(signal.SIGINT)
    assert stream.process.wait(START) == 0, stream.output.read_text()
    assert "targets sent" in stream.output.read_text()
    assert run_main("stream", "line", "--effector", "toe", *arguments) == 2


@pytest.mark.versions
def test_reach_needs_the_file(served: Served) -> None:
    receiver = find_receiver("beam", Network(served.port), StopFlag())
    assert receiver is not None
    assert receiver.description.effector_names == ("tip", "middle")
    assert receiver.robot is None
    with pytest.raises(PathError, match="reach is computed with the model of beam: give its file"):
        receiver_path("reach", receiver, PathSettings())
