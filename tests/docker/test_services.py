"""The services of the compose file, run without containers: their commands, health checks and stop signals.

They meet at a router with the shipped configuration and certificates, as in containers.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML
from support.processes import START, Process, run_main
from support.sites import Site, certificates

from tauten.service.link import ask_metrics, close_session
from tauten.service.log import LogReader
from tauten.service.plant import free_ports
from tauten.service.wire import Network, Role, open_session

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "operations.md").read_text()
GRACE = 10.0  # s; of compose, where a service does not say


def seconds(text: str) -> float:
    """Of a duration as the compose file has it."""
    return float(text.removesuffix("s"))


@dataclass(frozen=True)
class Service:
    """A service of the compose file, on this machine in place of a container.

    Attributes:
        name: of the service.
        definition: its part of the compose file.
        site: where its router is.
        folder: the volume, in which it works.
    """

    name: str
    definition: dict[str, Any]
    site: Site
    folder: Path

    def environment(self) -> dict[str, str]:
        """Variables of a process, with the configuration of its role."""
        (key,) = (
            one["source"] for one in self.definition["secrets"] if one["target"].endswith(".key")
        )
        configuration = self.site.client(key.removesuffix("_key"))
        given = self.definition["environment"] | {"TAUTEN_ZENOH_CONFIG": str(configuration)}
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        return {**os.environ, "PATH": path, **given}

    def command(self, *arguments: str) -> list[str]:
        """What the container runs; arguments take the place of its own command."""
        entry = self.definition.get("entrypoint", ["tauten"])
        command = list(arguments) or self.definition.get("command", [])
        return [word.replace("$$", "$") for word in [*entry, *command]]

    def start(self, *arguments: str) -> Process:
        """Start it."""
        output = self.folder / f"{self.name}.txt"
        with output.open("wb") as sink:
            process = subprocess.Popen(
                self.command(*arguments), cwd=self.folder, env=self.environment(), stdout=sink,
                stderr=subprocess.STDOUT,
            )  # fmt: skip
        return Process(process, output)

    def health(self) -> int:
        """The exit code of its health check, or of the image's where it has none."""
        found = self.definition.get("healthcheck", {}).get("test")
        if found is None:
            text = (ROOT / "docker" / "Dockerfile").read_text()
            (words,) = re.findall(r"HEALTHCHECK .*\\\n *CMD (\[.*\])\n", text)
            found = ["CMD", *json.loads(words)]
        done = subprocess.run(found[1:], env=self.environment(), timeout=START, check=False)
        return done.returncode

    def stop(self, process: Process) -> int:
        """Stop it as compose does; its exit code."""
        number = signal.Signals[self.definition.get("stop_signal", "SIGTERM")]
        process.process.send_signal(number)
        grace = seconds(self.definition.get("stop_grace_period", f"{GRACE}s"))
        return process.process.wait(grace)


Services = dict[str, Service]


@pytest.fixture
def services(tmp_path: Path) -> Iterator[Services]:
    """Those of tauten, and a router for them."""
    certificates(tmp_path)
    site = Site(tmp_path, free_ports(), password=False)
    volume = tmp_path / "logs"
    volume.mkdir()
    compose = YAML(typ="safe").load(ROOT / "docker" / "compose.yaml")
    router = site.router()
    yield {
        name: Service(name, definition, site, volume)
        for name, definition in compose["services"].items()
        if "build" in definition
    }
    close_session(router)


@contextmanager
def running(service: Service, *arguments: str) -> Iterator[Process]:
    """A service that runs until the block ends."""
    process = service.start(*arguments)
    try:
        yield process
    finally:
        process.process.kill()
        process.process.wait()


def until(done: Callable[[], bool], *processes: Process) -> None:
    """Wait while these processes run."""
    end = time.monotonic() + START
    while not done():
        for one in processes:
            assert one.process.poll() is None, one.output.read_text()
        assert time.monotonic() < end, [one.output.read_text() for one in processes]
        time.sleep(0.1)


@pytest.mark.long
def test_the_services_work_with_each_other_and_end_when_they_are_stopped(
    services: Services,
) -> None:
    orders = re.findall(r"compose.yaml run --rm operator (.*)", PAGE)
    assert orders == ["stream reach --robot finger", "command finger hold"]
    operator = services["operator"]
    names = ("plant", "node", "recorder")
    with ExitStack() as stack:
        on = {name: stack.enter_context(running(services[name])) for name in names}
        until(lambda: "serving finger" in on["node"].output.read_text(), *on.values())
        until(lambda: "recording finger" in on["recorder"].output.read_text(), *on.values())
        until(lambda: "driving finger" in on["plant"].output.read_text(), *on.values())
        assert services["node"].health() == services["plant"].health() == 0
        with running(operator, *orders[0].split()) as stream:
            configuration = Network(config=operator.site.client("viewer"))
            viewer = open_session(configuration, Role.OTHER, "finger")
            try:
                until(lambda: b'mode="run"' in (ask_metrics(viewer, "finger") or b""), stream)
            finally:
                close_session(viewer)
            assert operator.stop(stream) == 0
        with running(operator, *orders[1].split()) as hold:
            assert hold.process.wait(START) == 0
            assert hold.output.read_text().strip() == "finger: hold (operator)"
        for name in reversed(names):
            assert services[name].stop(on[name]) == 0, on[name].output.read_text()
    (log,) = operator.folder.glob("log-*.mcap")
    assert run_main("replay", log) == 0
    (beside,) = operator.folder.glob("beside-*.mcap")
    keys = {message.key for message in LogReader(beside).messages()}
    assert {"tauten/finger/target", "tauten/finger/plant/state", "tauten/finger/tick"} <= keys
