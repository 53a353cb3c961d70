"""One node that serves the small robot, and commands that do not outlive their test."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from support.processes import Process, Served, Start, client_of, start, wait_alive

from tauten.service.link import close_session
from tauten.service.plant import free_ports
from tauten.service.wire import Keys


@contextmanager
def serving(beam_file: Path, folder: Path, *options: str) -> Iterator[Served]:
    """A node that serves the small robot and records, and that ends with the block."""
    port, log = free_ports(), folder / "log.mcap"
    command = ("serve", beam_file, "--port", port, "--record", log, *options)
    process = start(folder / "serve.txt", *command)
    session = client_of(process, port)
    try:
        wait_alive(session, Keys("beam").token, process)
        yield Served(process, session, Keys("beam"), port, log)
    finally:
        close_session(session)
        if process.process.poll() is None:
            process.process.kill()
        process.process.wait()


@pytest.fixture
def served(request: pytest.FixtureRequest, beam_file: Path, tmp_path: Path) -> Iterator[Served]:
    """A node of this test; a parameter holds more options."""
    with serving(beam_file, tmp_path, *getattr(request, "param", ())) as found:
        yield found


@pytest.fixture(scope="module")
def shared(beam_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A node of all tests of a module that do not change what it does."""
    with serving(beam_file, tmp_path_factory.mktemp("shared")) as found:
        yield found


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
