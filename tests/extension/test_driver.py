"""The driver of docs/extend.md beside a node: a serial line, with a motor board at its other end."""

from __future__ import annotations

import logging
import os
import pty
import signal
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import zenoh
from support.nodes import answering as node
from support.processes import run_main
from support.robots.my_package import write_package

from tauten.model import ExtensionError
from tauten.model.numerics import Array
from tauten.service.describing import describe
from tauten.service.drive import Driver, DriverError, Measured, drive, make_driver
from tauten.service.plant import free_ports
from tauten.service.process import StopFlag, stop_on_signals
from tauten.service.setup import load_setup
from tauten.service.wire import (
    CDR,
    JOINTS,
    Joints,
    Keys,
    Network,
    Publisher,
    RobotDescription,
    decode_health,
    encode_joints,
    from_cdr,
)

PATIENCE = 60.0  # s
KEYS = Keys("beam")


@dataclass
class Board:
    """A motor board: it follows positions in micrometres while it is on, and answers where it is."""

    line: int
    device: str
    on: bool = False
    orders: list[str] = field(default_factory=list)
    position: str = "0 0"
    mute: bool = False
    lines: list[str] = field(default_factory=list)

    def run(self) -> None:
        """Until the line is closed."""
        text = b""
        while True:
            try:
                text += os.read(self.line, 4096)
            except OSError:
                return
            *whole, text = text.split(b"\n")
            for line in whole:
                self.obey(line.decode())

    def obey(self, line: str) -> None:
        """One line."""
        if line == "?":
            if self.mute:
                return
            os.write(self.line, f"{self.position}\n".encode())
        elif line in ("on", "off"):
            self.on = line == "on"
            self.orders.append(line)
        elif self.on:
            self.position = line
            self.lines.append(line)


@pytest.fixture
def board() -> Iterator[Board]:
    line, device = pty.openpty()
    tty.setraw(device)
    found = Board(line, os.ttyname(device))
    thread = threading.Thread(target=found.run, daemon=True)
    thread.start()
    yield found
    os.close(device)
    os.close(line)
    thread.join(PATIENCE)


def wait(what: Callable[[], bool]) -> None:
    """Until something is so."""
    end = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.long
def test_a_driver_follows_within_limits_and_stops_without_actuation(
    package: ModuleType, beam_file: Path, board: Board
) -> None:
    robot, stop = describe(load_setup(beam_file)), StopFlag()
    port, names = free_ports(), ("lower", "upper")
    driver: Driver = make_driver("winches")
    with node(robot, port) as session:
        state = session.declare_subscriber(KEYS.plant_state, zenoh.handlers.RingChannel(1))
        health = session.declare_subscriber(KEYS.plant_health, zenoh.handlers.RingChannel(100))
        arguments = ("beam", driver, {"device": board.device}, Network(port), stop)
        driving = threading.Thread(target=drive, args=arguments)
        driving.start()

        def follow(lower: float, upper: float, shown: str) -> None:
            """Publish an actuation as a node does until the board has it."""

            def arrived() -> bool:
                joints = Joints(time.time_ns(), robot.frame, names, (lower, upper), (1.0, 0.0))
                session.put(KEYS.actuation, encode_joints(joints), encoding=CDR)
                return bool(board.lines) and board.lines[-1] == shown

            wait(arrived)

        follow(0.001, 0.0, "1000 0")
        assert board.orders == ["on"]
        follow(0.5, -1.0, "20000 0")  # the robot's limits
        wait(lambda: _position(state) == pytest.approx([0.02, 0.0]))
        session.put(KEYS.actuation, b"nonsense", encoding=CDR)
        wait(lambda: board.orders == ["on", "off"])  # nothing arrives any more
        follow(0.002, 0.001, "2000 1000")
        assert board.orders == ["on", "off", "on"]
        wait(lambda: _refused(health) > 0)
        stop.request()
        driving.join(PATIENCE)
        assert not driving.is_alive()
    assert board.orders == ["on", "off", "on", "off"]
    assert not board.on
    driver._line.close()  # type: ignore[attr-defined]  # which the end of the process does


def _position(state: zenoh.Subscriber) -> list[float]:  # type: ignore[type-arg]
    """Measured positions; the board does not measure efforts."""
    sample = state.try_recv()
    if sample is None:
        return []
    message = from_cdr(JOINTS, sample.payload.to_bytes())
    assert list(message.name) == ["lower", "upper"]
    assert list(message.effort) == []
    return list(message.position)


def _refused(health: zenoh.Subscriber) -> int:  # type: ignore[type-arg]
    sample = health.try_recv()
    found = {} if sample is None else decode_health(sample.payload.to_bytes())
    if not isinstance(found, dict) or "actuation" not in found:
        return 0
    return int(found["actuation"].values["refused"])


def test_a_board_that_falls_silent_ends_the_driver(
    package: ModuleType, beam_file: Path, board: Board
) -> None:
    """With one sentence, and switched off: the page's driver waits for a tenth of a second."""
    driver, robot = make_driver("winches"), describe(load_setup(beam_file))
    driver.configure(robot, {"device": board.device})
    driver.activate()
    board.mute = True
    with pytest.raises(DriverError, match="0 of 2 answer"):
        driver.read()
    driver._line.close()  # type: ignore[attr-defined]


class Stuck(Driver):
    """Hardware whose measurement never comes, or fails."""

    def __init__(self, error: Exception | None = None) -> None:
        self.calls: list[str] = []
        self.error = error

    def configure(self, robot: RobotDescription, options: Mapping[str, str]) -> None:
        self.calls.append("configure")

    def activate(self) -> None:
        self.calls.append("activate")
        if self.error is not None:
            raise self.error

    def read(self) -> Measured:
        if "activate" in self.calls:
            self.calls.append("read")
            signal.raise_signal(signal.SIGINT)
            time.sleep(PATIENCE)
        return Measured(*np.full((2, 2), np.nan))

    def write(self, position: Array, effort: Array) -> None:
        pass

    def deactivate(self) -> None:
        self.calls.append("deactivate")


def driven(driver: Driver, beam_file: Path) -> StopFlag:
    """A driver beside a node that publishes, until it ends."""
    robot, port, ended = describe(load_setup(beam_file)), free_ports(), threading.Event()
    with node(robot, port) as session:

        def publish() -> None:
            while not ended.wait(0.01):
                joints = Joints(0, robot.frame, ("lower", "upper"), (0.001, 0.0), (1.0, 0.0))
                session.put(KEYS.actuation, encode_joints(joints), encoding=CDR)

        thread = threading.Thread(target=publish)
        thread.start()
        try:
            with stop_on_signals() as stop:
                drive("beam", driver, {}, Network(port), stop)
        finally:
            ended.set()
            thread.join()
    return stop


@pytest.mark.long
def test_a_driver_that_waits_for_ever_ends_with_ctrl_c(
    beam_file: Path, caplog: pytest.LogCaptureFixture
) -> None:
    driver, begin = Stuck(), time.monotonic()
    assert driven(driver, beam_file).requested
    assert driver.calls == ["configure", "activate", "read", "deactivate"]
    assert time.monotonic() - begin < PATIENCE
    assert "a call of the driver of beam has not ended" in caplog.text


@pytest.mark.long
def test_a_driver_that_is_asked_to_end_warns_of_nothing(
    beam_file: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    driver = Stuck()

    def read() -> Measured:
        if "activate" in driver.calls:
            signal.raise_signal(signal.SIGINT)
        return Measured(*np.full((2, 2), np.nan))

    driver.read = read  # type: ignore[method-assign]
    assert driven(driver, beam_file).requested
    said = {one.levelname for one in caplog.records if "is deactivated" in one.getMessage()}
    assert said == {"INFO"}


@pytest.mark.long
def test_hardware_that_fails_is_named_and_deactivated(beam_file: Path) -> None:
    """Also where only a part of it has been activated."""
    driver = Stuck(OSError(5, "Input/output error"))
    with pytest.raises(DriverError, match=r"the driver of beam fails: .*Input/output error"):
        driven(driver, beam_file)
    assert driver.calls == ["configure", "activate", "deactivate"]


@pytest.mark.long
def test_code_of_a_driver_that_fails_is_named_with_its_line(beam_file: Path) -> None:
    """It was a traceback with exit code 1."""
    driver = Stuck(KeyError("motor"))
    with pytest.raises(
        ExtensionError, match=r"driver of beam has failed with KeyError: 'motor' \("
    ):
        driven(driver, beam_file)
    assert driver.calls == ["configure", "activate", "deactivate"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (None, "returns NoneType, expected Measured"),
        (Measured(np.zeros(4), np.zeros(2)), r"gives position of shape \(4,\), expected \(2,\)"),
        (Measured(["on", "off"], np.zeros(2)), r"gives position: could not convert .* 'on'"),
        *(
            pytest.param(*case, marks=pytest.mark.slow)  # each opens a session
            for case in (
                (
                    Measured(np.zeros(2), np.float64(0.0)),
                    r"gives effort of shape \(\), expected \(2,\)",
                ),
                (
                    Measured(*np.zeros((2, 2)), np.zeros((1, 3))),
                    r"gives effectors of shape \(1, 3\)",
                ),
                (Measured(np.zeros(2), [[0.0], [0.0, 1.0]]), "gives effort: .*inhomogeneous"),
                (Measured(*np.zeros((2, 2)), gap="none"), "gives gap: could not convert"),
            )
        ),
    ],
)
def test_what_is_no_measurement_of_the_robot_ends_its_driver(
    beam_file: Path, answer: Measured, message: str
) -> None:
    """Two positions too many were published; others ended in a traceback, as texts and ragged lists did."""
    driver = Stuck()
    driver.read = lambda: answer  # type: ignore[method-assign]
    with pytest.raises(DriverError, match=rf"the driver of beam fails: its read\(\) {message}"):
        driven(driver, beam_file)
    assert driver.calls[-1] != "read"


@pytest.mark.long
def test_the_network_is_not_blamed_on_the_hardware(
    beam_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    driver = Stuck()
    driver.read = lambda: Measured(*np.zeros((2, 2)))  # type: ignore[method-assign]

    def fails(self: Publisher, payload: bytes) -> None:
        raise OSError("the session is closed")

    monkeypatch.setattr(Publisher, "put", fails)
    with pytest.raises(OSError, match=r"^the session is closed"):
        driven(driver, beam_file)
    assert driver.calls[-1] != "read"


@pytest.mark.parametrize(
    ("made", "message"),
    [
        ("PLUGS = 3", "my_driver:PLUGS is no function or class: found int"),
        ("def PLUGS(port): pass", "driver plugs.parameters: 'port' is missing"),
        ("class PLUGS:\n    read = write = print", "lacks configure, activate, deactivate"),
    ],
)
def test_what_is_no_driver_is_refused(
    made: str,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """In one sentence; it was a traceback, where methods are missing only when they were needed."""
    write_package(tmp_path, "my_driver", made, {"tauten.drivers": {"plugs": "my_driver:PLUGS"}})
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "my_driver", raising=False)
    assert run_main("drive", "beam", "--driver", "plugs") == 2
    assert message in capsys.readouterr().err


def test_a_driver_says_what_it_needs(package: ModuleType, beam_file: Path) -> None:
    with pytest.raises(DriverError, match="--option device=/dev/ttyUSB0"):
        make_driver("winches").configure(describe(load_setup(beam_file)), {})


def test_the_command_names_what_is_installed(
    package: ModuleType, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_main("drive", "beam", "--driver", "none") == 2
    assert "no driver 'none'; installed packages have: winches" in capsys.readouterr().err
    assert run_main("drive", "beam", "--driver", "winches", "--option", "device") == 2
    assert "--option device: expected NAME=VALUE" in capsys.readouterr().err.replace("\n", " ")
