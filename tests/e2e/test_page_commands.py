"""Blocks of shell commands in README, docs and tutorials: a test runs them, or a table says why not."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from support.nodes import wait_mode
from support.processes import Process, Served, run_main, start, wait_alive
from support.robots.examples import shipped_setup
from support.robots.thumb import write_thumb

from tauten.controller import warm_controller
from tauten.service.link import close_session
from tauten.service.plant import free_ports
from tauten.service.wire import Keys, Mode, Network, Role, open_session

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"^ *```sh\n(.*?)^ *```", re.DOTALL | re.MULTILINE)

# The first command of each block: the test that runs it.
HERE = {
    "tauten serve finger --record run.mcap": "test_a_robot_is_served_followed_locked_and_replayed",
    "tauten plant finger": "test_a_robot_is_served_followed_locked_and_replayed",
    "tauten stream reach --robot finger": "test_a_robot_is_served_followed_locked_and_replayed",
    "tauten lock finger tendon --position 0.004": "test_a_robot_is_served_followed_locked_and_replayed",
    "tauten replay run.mcap": "test_a_robot_is_served_followed_locked_and_replayed",
    "tauten compare ROBOT --figure contact.png": "test_the_tutorial_of_the_contact_basis",
    "tauten reduce ROBOT --out ROBOT.basis": "test_the_tutorial_of_the_contact_basis",
    "tauten inspect ROBOT.basis --figure modes.png": "test_the_tutorial_of_the_contact_basis",
    "openssl req -x509": "test_certificates_are_made",
    "tauten schema": "test_the_schema_is_json",
    "tauten kernels": "test_kernels_are_counted",
}
# Blocks whose page `test_site` runs as a whole, each command as it is written (slow).
FILMED = {"docs/start.md", "docs/tutorials/own_robot.md"}
# The first command of each block that no test runs, and why.
NOT_RUN = {
    "pytest": "runs these tests; tests/benchmarks/test_kernels packs and uses one kernel",
    "python3 -m venv .venv && .venv/bin/pip install -e '.[fast,test]'": "installs; .ci/run does it",
    "python3 -m venv .venv && . .venv/bin/activate": "installs; test_site does it as docs/start.md has it",
    ".ci/run": "runs these tests",
    "tauten reduce finger": "minutes; the tutorial's block, which runs, does the same with the thumb",
    "tauten reduce finger --states": "as above; tests/e2e/reduction reduces the thumb's states",
    "tauten reduce examples/quick_claw.toml": "minutes; tests/reduction/campaign has one like it",
    "tauten reduce manipulator --design plackett-burman": "hours",
    "tauten reduce manipulator --states": "hours",
    "tauten check manipulator --refinements 2": "an hour; its results are in docs/results",
    "tauten serve examples/arm.toml --closed-loop": "minutes; tests/test_examples moves its driver",
    "tauten demo examples/hand.toml": "as the demo; tests/service/test_parts runs one of parts",
    "tauten demo manipulator": "three minutes of real time; tests/e2e/gallery follows targets with it",
    "python -m benchmarks.robots.make_finger coarse": "minutes to an hour; its results are in docs/results",
    "python -m benchmarks still --robot manipulator_1290": "minutes; its results are in docs/results",
    "python -m benchmarks still --model full": "an hour; its results are in docs/results",
    "python -m benchmarks load-errors": "half an hour and more; its results are in the page",
    "sudo useradd": "changes the system; tests/docker checks the unit that it installs",
    "sudo chown": "needs root and a container engine; tests/docker checks the file and runs its steps",
    "nft add rule": "changes the firewall",
    "ssh -L": "needs a second computer; tests/service/view/test_guard has the tunnel's addresses",
}


def blocks() -> list[tuple[str, str]]:
    """Page and code of every block."""
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    return [
        (page.relative_to(ROOT).as_posix(), code.strip())
        for page in sorted(pages)
        if "_build" not in page.parts
        for code in BLOCK.findall(page.read_text(encoding="utf-8"))
    ]


def test_every_block_is_run_or_says_why_not() -> None:
    tables = {**HERE, **NOT_RUN}
    found = {
        start: page
        for page, code in blocks()
        if page not in FILMED
        for start in [max((one for one in tables if code.startswith(one)), key=len, default="")]
        if start
        or pytest.fail(f"{page}: no test runs {code.splitlines()[0]!r}, and no reason is given")
    }
    everywhere = [code for _, code in blocks()]
    assert all(any(code.startswith(one) for code in everywhere) for one in tables)
    assert len(found) > 15
    assert {name for name in HERE.values()} <= set(globals())


def words(line: str) -> list[str]:
    """The words of a command after `tauten`, without its comment."""
    name, *rest = shlex.split(line, comments=True)
    assert name == "tauten"
    return rest


def lines_of(page: str, *starts: str) -> list[list[str]]:
    """Words of the commands of a page that start so; each is there."""
    lines = [line for name, code in blocks() if name == page for line in code.splitlines()]
    return [words(next(line for line in lines if line.startswith(one))) for one in starts]


@contextmanager
def running(folder: Path, *arguments: object) -> Iterator[Process]:
    """A command that does not outlive the block."""
    process = start(folder / f"{arguments[0]}.txt", *arguments)
    try:
        yield process
    finally:
        if process.process.poll() is None:
            process.process.kill()
        process.process.wait()


@pytest.mark.long
def test_a_robot_is_served_followed_locked_and_replayed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The three terminals of docs/start.md, and the lock of docs/actuators.md, at ports of their own."""
    monkeypatch.chdir(tmp_path)
    serve, plant, stream = lines_of(
        "docs/start.md", "tauten serve finger", "tauten plant finger", "tauten stream reach"
    )
    lock, unlock = lines_of("docs/actuators.md", "tauten lock", "tauten unlock")
    replay = lines_of("docs/start.md", "tauten replay")[0]
    # kernels are compiled here, where no time limit runs
    warm_controller(shipped_setup("finger"))
    port = free_ports()
    here, keys = ("--port", port), Keys("finger")
    session = open_session(Network(port), Role.OTHER, "finger")
    try:
        with (
            running(tmp_path, *serve, *here) as node,
            running(tmp_path, *plant, *here) as body,
            running(tmp_path, *stream, *here) as sender,
        ):
            wait_alive(session, keys.token, node)
            wait_mode(Served(node, session, keys, port, tmp_path / "run.mcap"), Mode.RUN)
            for order in (lock, unlock):
                assert run_main(*order, *here) == 0
            assert sender.end() == 0, sender.output.read_text()
            assert node.end() == 0, node.output.read_text()
            assert body.end() == 0, body.output.read_text()
    finally:
        close_session(session)
    assert run_main(*replay) == 0


@pytest.mark.slow
def test_the_tutorial_of_the_contact_basis(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the thumb as ROBOT."""
    monkeypatch.chdir(tmp_path)
    write_thumb(tmp_path)
    for command in lines_of(
        "docs/tutorials/contact_basis.md",
        "tauten compare ROBOT --figure", "tauten reduce ROBOT --out", "tauten inspect ROBOT.basis",
    ):  # fmt: skip
        named = [
            re.sub(r"^ROBOT$", "thumb.toml", word).replace("ROBOT", "thumb") for word in command
        ]
        assert run_main(*named) == 0
    for name in ("contact.png", "thumb.basis", "modes.png"):
        assert (tmp_path / name).stat().st_size > 1000


@pytest.mark.skipif(not shutil.which("openssl"), reason="no openssl here")
def test_certificates_are_made(tmp_path: Path) -> None:
    (code,) = (code for page, code in blocks() if page == "docs/security.md" and "openssl" in code)
    subprocess.run(["bash", "-ec", code], cwd=tmp_path, check=True, capture_output=True)
    for role in ("router", "camera"):
        done = subprocess.run(
            ["openssl", "verify", "-CAfile", "ca.pem", f"{role}.pem"], cwd=tmp_path, check=False
        )
        assert done.returncode == 0


def test_kernels_are_counted(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_main(*lines_of("docs/operations.md", "tauten kernels")[0]) == 0
    assert "kernels of tauten" in capsys.readouterr().out


@pytest.mark.long
def test_a_folder_that_keeps_no_kernels_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One that cannot be made, and one that others can write."""
    (tmp_path / "file").touch()
    (tmp_path / "open" / "tauten" / "kernels").mkdir(parents=True)
    (tmp_path / "open" / "tauten" / "kernels").chmod(0o777)
    reasons = {
        "file": "file/tauten: not a directory",
        "open": "open/tauten/kernels: others can write it",
    }
    for name, reason in reasons.items():
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / name))
        assert run_main("kernels") == 0
        assert (
            f"they cannot be kept: {tmp_path}/{reason}; set NUMBA_CACHE_DIR"
            in capsys.readouterr().out
        )


def test_the_schema_is_json(capsys: pytest.CaptureFixture[str]) -> None:
    command = lines_of("docs/reference/robot-file.md", "tauten schema")[0]
    assert run_main(*command[: command.index(">")]) == 0
    assert "anyOf" in json.loads(capsys.readouterr().out)
