"""One node that serves the small robot, and commands that do not outlive their test."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from support.processes import Process, Served, Start, start, wait_alive

from tauten.service.plant import free_ports
from tauten.service.wire import Keys, Network, Role, open_session


@pytest.fixture
def served(request: pytest.FixtureRequest, beam_file: Path, tmp_path: Path) -> Iterator[Served]:
    """A node that serves the small robot and records; a parameter holds more options."""
    options: tuple[str, ...] = getattr(request, "param", ())
    port, log = free_ports(), tmp_path / "log.mcap"
    serving = ("serve", beam_file, "--port", port, "--record", log, *options)
    process = start(tmp_path / "serve.txt", *serving)
    session = open_session(Network(port), Role.OTHER, "beam")
    try:
        wait_alive(session, Keys("beam").token, process)
        yield Served(process, session, Keys("beam"), port, log)
    finally:
        session.close()  # type: ignore[no-untyped-call]
        if process.process.poll() is None:
            process.process.kill()
        process.process.wait()


@pytest.fixture
def run(tmp_path: Path) -> Iterator[Start]:
    """Starts `tauten` commands that do not outlive the test."""
    started: list[Process] = []

    def it(*arguments: object) -> Process:
        started.append(start(tmp_path / f"{arguments[0]}{len(started)}.txt", *arguments))
        return started[-1]

    yield it
    for process in started:
        if process.process.poll() is None:
            process.process.kill()
        process.process.wait()
