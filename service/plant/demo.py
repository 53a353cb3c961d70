"""The demo: node, plant and stream as processes of their own, then a report of what they did."""

from __future__ import annotations

import contextlib
import csv
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from tauten.service.plant.paths import PathSettings, TargetPath, make_path
from tauten.service.plant.plant import Drive
from tauten.service.plots import draw_run
from tauten.service.process import StopFlag
from tauten.service.replay import Report, make_report, read_run
from tauten.service.setup import Order, load_setup
from tauten.service.wire import Keys, Network, Role, is_alive, open_session

LOG, REPORT, FIGURE, TARGETS = "log.mcap", "report.json", "figure.png", "targets.csv"

_START = 300.0  # s; kernels are compiled when a robot runs for the first time
_YIELD = 10  # niceness of plant and stream
_STOP = 20.0  # s, the release of the cables included
_PORTS = range(28_000, 32_000, 2)


class DemoError(RuntimeError):
    """A process of the demo that did not do its part; the text says which and where to look."""


@dataclass(frozen=True, slots=True)
class DemoSettings:
    """What the demo does.

    Attributes:
        robot: name or file.
        folder: where log, report and figure go.
        seconds: of targets.
        path: of the targets, as for `tauten stream`.
        period: of one pass [s].
        fraction: of the largest pull, for "reach".
        basis: of the node, as for `tauten serve`.
        model: of the node, as for `tauten serve`.
        closed_loop: whether the plant's measurements correct the targets.
        young_scale: the plant's Young's modulus, as a multiple of the robot file's.
        drive: what the plant's winches obey, as for `tauten plant`.
    """

    robot: str
    folder: Path
    seconds: float
    path: str = "reach"
    period: float = 10.0
    fraction: float = 0.8
    basis: str | None = None
    model: Order | None = None
    closed_loop: bool = False
    young_scale: float = 1.0
    drive: Drive = "pull"


@dataclass(slots=True)
class Child:
    """A process of the demo."""

    name: str
    process: subprocess.Popen[bytes]
    output: Path

    def check(self) -> None:
        """Make sure that it has not ended in error.

        Raises:
            DemoError: it has.
        """
        code = self.process.poll()
        if code not in (None, 0):
            lines = self.output.read_text(encoding="utf-8", errors="replace").strip().splitlines()
            last = lines[-1].removeprefix("tauten: ") if lines else "no output"
            raise DemoError(f"tauten {self.name} ended with {code}: {last} (see {self.output})")


def run_demo(settings: DemoSettings, stop: StopFlag, say: Callable[[str], None]) -> Report:
    """Run the demo and leave a folder.

    Args:
        settings: what to do.
        stop: raised to end early; what has been recorded is still reported.
        say: told what is happening.

    Raises:
        DemoError: a process failed.
        RobotFileError, MeshError, BasisError, PathError: what cannot be used, and why.
        LogError: nothing was recorded.
    """
    robot = load_setup(settings.robot, basis=settings.basis, model=settings.model).robot
    folder = settings.folder
    folder.mkdir(parents=True, exist_ok=True)
    port = free_ports()
    common = ["--port", str(port)]
    targets, log = folder / TARGETS, folder / LOG
    say("finding targets that can be reached, kernels are compiled the first time")
    path_settings = PathSettings(period=settings.period, fraction=settings.fraction)
    save_path(make_path(settings.path, robot, path_settings), targets)
    say("starting node, plant and stream")
    with contextlib.ExitStack() as stack:
        serving = [settings.robot, "--record", str(log), *common]
        if settings.basis is not None:
            serving += ["--basis", settings.basis]
        if settings.model is not None:
            serving += ["--model", settings.model]
        behaving = ["--young-scale", repr(settings.young_scale), "--drive", settings.drive]
        if settings.closed_loop:
            serving.append("--closed-loop")
            behaving.append("--measure")
        sending = [str(targets), "--robot", settings.robot, "--repeat", "--await-plant", *common]
        sending += ["--rate", repr(robot.config.controller.rate)]
        sending += ["--duration", repr(settings.seconds)]
        node = stack.enter_context(child("serve", serving, folder))
        plant = stack.enter_context(child("plant", [settings.robot, *behaving, *common], folder))
        sender = stack.enter_context(child("stream", sending, folder))
        _wait_alive(Keys(robot.name), Network(port), (node, plant, sender), stop)
        say(f"following targets for {settings.seconds:g} s")
        _wait_end(sender, (node, plant), stop)
        say("releasing the cables")
        _end(node)
        _end(plant)
    say("reading the log")
    return _report(folder, robot.cable_names)


def _report(folder: Path, cables: tuple[str, ...]) -> Report:
    run = read_run(folder / LOG)
    report = make_report(run)
    report.save(folder / REPORT)
    draw_run(run, cables, folder / FIGURE)
    return report


def save_path(path: TargetPath, file: Path) -> None:
    """Write a path as the CSV that `tauten stream` reads."""
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(["t", "x", "y", "z"])
        for time_, (x, y, z) in zip(path.times.tolist(), path.points.tolist(), strict=True):
            writer.writerow([repr(value) for value in (time_, x, y, z)])


def free_ports() -> int:
    """The first of two TCP ports of loopback that nobody uses.

    Raises:
        DemoError: there are none.
    """
    start = os.getpid() % len(_PORTS)
    ports: list[int] = [*_PORTS[start:], *_PORTS[:start]]
    for port in ports:
        if _is_free(port) and _is_free(port + 1):
            return port
    raise DemoError(f"no two free TCP ports from {_PORTS.start} to {_PORTS.stop} on loopback")


def _is_free(port: int) -> bool:
    with socket.socket() as probe:
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
        return True


@contextlib.contextmanager
def child(command: str, arguments: list[str], folder: Path) -> Iterator[Child]:
    """A `tauten` command as a process; asked to end, then made to, when the block is left."""
    output = folder / f"{command}.txt"
    with output.open("wb") as sink:
        process = _start(command, arguments, sink)
        if command != "serve":
            # a real robot does not take the node's processor; here it shares it, and yields
            os.setpriority(os.PRIO_PROCESS, process.pid, _YIELD)
        found = Child(command, process, output)
        try:
            yield found
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
                try:
                    process.wait(_STOP)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()


def _start(command: str, arguments: list[str], sink: IO[bytes]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "tauten.service", command, *arguments],
        stdin=subprocess.DEVNULL,
        stdout=sink,
        stderr=subprocess.STDOUT,
    )


def _wait_alive(keys: Keys, network: Network, children: tuple[Child, ...], stop: StopFlag) -> None:
    session = open_session(network, Role.OTHER, keys.robot)
    try:
        end = time.monotonic() + _START
        missing = {keys.token, keys.plant_token}
        while missing and not stop.requested:
            for one in children:
                one.check()
            if time.monotonic() > end:
                raise DemoError(f"{', '.join(sorted(missing))} did not start within {_START:g} s")
            missing -= {key for key in missing if is_alive(session, key)}
            time.sleep(0.1)
    finally:
        session.close()  # type: ignore[no-untyped-call]


def _wait_end(sender: Child, others: tuple[Child, ...], stop: StopFlag) -> None:
    while sender.process.poll() is None and not stop.requested:
        for one in others:
            one.check()
        time.sleep(0.05)
    if not stop.requested:
        sender.check()


def _end(one: Child) -> None:
    """Ask a process to end as Ctrl-C does, and wait until it has."""
    if one.process.poll() is None:
        one.process.send_signal(signal.SIGINT)
    try:
        one.process.wait(_STOP)
    except subprocess.TimeoutExpired as error:
        raise DemoError(f"tauten {one.name} did not end within {_STOP:g} s") from error
    one.check()
