"""The pages of the repository: links lead somewhere in a clone, commands exist, blocks of code run."""

from __future__ import annotations

import re
import shlex
import subprocess
import tomllib
from collections.abc import Callable, Iterator
from functools import cache
from math import nan
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import reference_pages
import robot_file_page
import typer
from rosbags.typesys import get_types_from_msg
from support.robots.bodies import hollow_beam, pneumatic_config

from benchmarks.commands import app as benchmarks_app
from tauten.controller import Controller
from tauten.controller.settings import ControllerSettings
from tauten.model import Simulator
from tauten.model.load import build_robot
from tauten.model.schema import RobotConfig
from tauten.service.cli.app import app
from tauten.service.codec.messages import TICK, TICK_DEFINITION
from tauten.service.file_schema import robot_file_schema

ROOT = Path(__file__).resolve().parents[1]
BLOCK = re.compile(r"^( *)```(\w*)[^\n]*\n(.*?)^ *```", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
COMMAND = re.compile(r"(?:\S*/bin/)?(?:tauten|python -m benchmarks) ")


@cache
def in_clone() -> set[Path]:
    """The files that git has; the test is skipped in a tree without it."""
    done = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        pytest.skip("no git here")
    return {ROOT / name for name in done.stdout.splitlines()}


PAGES = sorted(
    [*ROOT.glob("*.md"), *(page for page in (ROOT / "docs").rglob("*.md") if "_build" not in page.parts)]
)  # fmt: skip
WRITTEN = [
    page for page in PAGES if page.name != "CHANGELOG.md" and page.parent.name != "reference"
]
by_name = pytest.mark.parametrize(
    "page", WRITTEN, ids=lambda page: page.relative_to(ROOT).as_posix()
)


def blocks(page: Path, language: str) -> list[str]:
    """The blocks of code of a language."""
    found = BLOCK.finditer(page.read_text(encoding="utf-8"))
    return [match.group(3) for match in found if match.group(2) == language]


@by_name
def test_links_lead_to_what_a_clone_has(page: Path) -> None:
    files = in_clone()
    if page not in files:
        pytest.skip("made here, not part of a clone")
    text = BLOCK.sub("", page.read_text(encoding="utf-8"))
    for target in LINK.findall(text):
        if target.startswith(("http", "mailto")):
            continue
        path = (page.parent / target).resolve()
        assert path in files or any(path in file.parents for file in files), target


def test_the_page_has_the_definition_of_a_tick() -> None:
    """Without it nobody can read a tick who has no log."""
    (text,) = blocks(ROOT / "docs" / "reference" / "messages.md", "text")
    assert get_types_from_msg(text, TICK) == get_types_from_msg(TICK_DEFINITION, TICK)


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("robot-file.md", robot_file_page.robot_file_page),  # from the schema
        ("python.md", reference_pages.python_page),  # from the faces of the folders
    ],
)
def test_pages_of_the_reference_are_those_that_the_program_writes(
    name: str, written: Callable[[], str]
) -> None:
    """That of Python was three names behind: only a build of the site writes it."""
    page = ROOT / "docs" / "reference" / name
    assert page in in_clone()
    text = page.read_text(encoding="utf-8")
    assert text == written(), "run python docs/scripts/reference_pages.py"


def commands(page: Path) -> Iterator[str]:
    """The calls of `tauten` and of benchmarks in blocks for a shell and within sentences."""
    for block in blocks(page, "sh"):
        for line in block.replace("\\\n", " ").splitlines():
            if COMMAND.match(line.strip()):
                yield line.strip()
    text = BLOCK.sub("", page.read_text(encoding="utf-8"))
    for code in re.findall(r"`([^`]+)`", text):
        if COMMAND.match(code):
            yield " ".join(code.split())


@cache
def program(name: str) -> Any:
    """All commands of `tauten`, or of `python -m benchmarks`."""
    return typer.main.get_command(app if name == "tauten" else benchmarks_app)


def wrong(command: str) -> str:
    """What a call has that the program does not know; "" where it knows all of it."""
    words = shlex.split(command, comments=True)
    ends = [words.index(sign) for sign in ("|", "||", "&&", "&", ";", ">", "<") if sign in words]
    words = words[: min(ends, default=len(words))]
    name = "tauten" if words[0].endswith("tauten") else "benchmarks"
    known, words = (
        program(name),
        words[words.index("benchmarks") + 1 if name == "benchmarks" else 1 :],
    )
    options = {"--help"}
    while True:
        here = [name for item in known.params for name in (*item.opts, *item.secondary_opts)]
        options |= {name for name in here if name.startswith("-")}
        following = next((word for word in words if not word.startswith("-")), None)
        if not hasattr(known, "commands") or following is None:
            break
        if words.index(following) and words[0].split("=")[0] not in options:
            return f"no option {words[0]}"
        if following not in known.commands:
            takes_value = words.index(following) > 0 and words[0].startswith("--")
            if not takes_value:
                return f"no command {following}"
            words.remove(following)
            continue
        known = known.commands[following]
        words = words[words.index(following) + 1 :]
    strange = [
        word for word in words
        if re.match(r"--[a-z]", word) and word.split("=")[0] not in options
    ]  # fmt: skip
    return f"no option {strange[0]}" if strange else ""


@by_name
def test_commands_exist_with_their_options(page: Path) -> None:
    for command in commands(page):
        assert not wrong(command), f"{command}: {wrong(command)}"


@pytest.mark.parametrize(
    ("command", "found"),
    [
        ("tauten serve finger --record run.mcap  # and more", ""),
        ("tauten bench node finger --viewer", ""),
        ("tauten --log-format json serve finger", ""),
        ("tauten replay run.mcap --figure run.png", "no option --figure"),
        ("tauten bench nothing", "no command nothing"),
        ("python -m benchmarks qpcc --json qpcc.json", ""),
        ("python -m benchmarks qpcc --figure qpcc.png", "no option --figure"),
        ("tauten dance", "no command dance"),
    ],
)
def test_a_command_that_does_not_exist_is_found(command: str, found: str) -> None:
    assert wrong(command) == found


def balloon(folder: Path) -> RobotConfig:
    """The robot that fragments of pages speak of: a cable and a chamber."""
    mesh = hollow_beam()
    meshio.write(folder / "balloon.vtu", meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]))
    cable = {
        "name": "tendon", "points": [[0.01, 0.01, 0.002], [0.1, 0.01, 0.002]],
        "max_tension": 20.0, "max_pull": 0.02, "max_rate": 0.1,
    }  # fmt: skip
    return RobotConfig.model_validate(pneumatic_config(cables=[cable]))


FRAGMENTS = {"actuators.md", "effectors.md"}  # they go on from a simulator or a controller
LONG = {"README.md", "start.md", "mujoco.md"}  # run by slow tests


@by_name
def test_python_runs(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of long blocks, which a slow test runs, the imports; `test_lessons` runs lessons."""
    if page.parent.name == "lessons":
        return
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("builtins.input", lambda text="": "")
    names: dict[str, Any] = {"nan": nan}
    for code in blocks(page, "python"):
        if page.name in FRAGMENTS and "simulator" not in names:
            config = balloon(tmp_path)
            if page.name == "effectors.md":
                end = {"lower": [0.09, -1.0, -1.0], "upper": [1.0, 1.0, 1.0]}
                tool = {"name": "tool", "kind": "frame", "region": end}
                config = RobotConfig.model_validate(
                    {**config.model_dump(exclude_unset=True), "effectors": [tool]}
                )
            robot = build_robot(config, hollow_beam(), str(tmp_path / "balloon.toml"))
            names |= {"simulator": Simulator(robot, "none"), "controller": Controller(robot)}
        if "tripod_low.gidmsh" in code:
            write_gidmsh(tmp_path / "tripod_low.gidmsh")
        lines = code.splitlines()
        if page.name in LONG:
            compile(code, str(page), "exec")
            code = "\n".join(line for line in lines if line.startswith(("from ", "import ")))
        exec(compile(code, str(page), "exec"), names)
    if page.name == "sofa.md":
        made = meshio.read(tmp_path / "tripod_low.vtu")
        assert len(made.points) == 5
        assert np.array_equal(made.cells[0].data, [[0, 1, 2, 3], [1, 2, 3, 4]])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["start.md", "coming_from/mujoco.md"])
def test_long_python_runs(name: str) -> None:
    (code,) = blocks(ROOT / "docs" / name, "python")
    exec(compile(code, name, "exec"), {})


def write_gidmsh(path: Path) -> None:
    """Two tetrahedra in the format of the tripod's mesh."""
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]
    lines = ["MESH dimension 3 ElemType Tetrahedra Nnode 4", "Coordinates"]
    lines += [f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(points, 1)]
    lines += ["End Coordinates", "", "Elements", "1 1 2 3 4", "2 2 3 4 5", "End Elements", ""]
    path.write_text("\n".join(lines))


@cache
def schema() -> dict[str, Any]:
    """Of robot files."""
    return robot_file_schema()


def fields_of(part: Any) -> set[str]:
    """Fields of the tables that a part of the schema refers to."""
    tables = schema()["$defs"]
    if isinstance(part, list):
        return {field for item in part for field in fields_of(item)}
    if not isinstance(part, dict):
        return set()
    if "$ref" in part:
        return set(tables[part["$ref"].rsplit("/", 1)[-1]].get("properties", {}))
    return {
        field for key in ("anyOf", "oneOf", "allOf", "items") for field in fields_of(part.get(key))
    }


@by_name
def test_tables_of_robot_files_have_known_fields(page: Path) -> None:
    """Of whole files and of parts; values of whole files are tested with the pages that have them."""
    known: dict[str, list[Any]] = {}
    for item in schema()["anyOf"]:
        for name, part in schema()["$defs"][item["$ref"].rsplit("/", 1)[-1]]["properties"].items():
            known.setdefault(name, []).append(part)
    for block in blocks(page, "toml"):
        contents = tomllib.loads(block)
        if "project" in contents:  # the pyproject.toml of a package
            continue
        for name, value in contents.items():
            assert name in known, name
            rows = value if isinstance(value, list) else [value]
            found = {field for row in rows if isinstance(row, dict) for field in row}
            assert found <= fields_of(known[name]), f"{name}: {found - fields_of(known[name])}"


def test_what_is_said_of_qp_libraries_is_what_was_measured() -> None:
    """The settings named proxqp beside daqp, with which few decisions end OK."""
    table = (ROOT / "docs" / "qpcc.md").read_text(encoding="utf-8").partition("| library |")[2]
    lines = [line.split("|") for line in table.partition("\n\n")[0].splitlines()[2:]]
    least = {
        line[1].strip(): min(int(one) for one in re.findall(r"(\d+) %", "".join(line[2:])))
        for line in lines
    }
    said = " ".join(str(ControllerSettings.model_fields["qp_solver"].description).split())
    good, _, poor = said.partition("more slowly")
    assert least and all(name in (good if share >= 95 else poor) for name, share in least.items())
