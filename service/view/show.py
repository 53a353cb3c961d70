"""Viewers from start to end: load, open the server, show, close; or write a run as an HTML file."""

from __future__ import annotations

import logging
import math
import webbrowser
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import TypeVar

from tauten.controller import Order
from tauten.model import one_blas_thread
from tauten.model.schema import read_toml
from tauten.service.frames import (
    ReachSearch,
    RecordedRobot,
    ServedRobot,
    SimulatedRobot,
    ViewFrame,
)
from tauten.service.kernels import waiting
from tauten.service.link import HOST, node_of
from tauten.service.plant import (
    PathError,
    PathSettings,
    TargetPath,
    make_path,
    plant_robot,
    plant_setup,
)
from tauten.service.process import Progress, StopFlag
from tauten.service.setup import load_setup
from tauten.service.view.export import write_html
from tauten.service.view.playback import PlaybackSession
from tauten.service.view.session import FRAMES, ViewSession
from tauten.service.view.web import FIRST_PORT, open_server
from tauten.service.wire import Network, places_of

log = logging.getLogger(__name__)

Frame = TypeVar("Frame")


@dataclass(frozen=True, slots=True)
class ViewSettings:
    """How a robot is shown.

    Attributes:
        port: TCP port of the web page; 0: any free one.
        browser: whether the default browser is opened.
        seconds: duration; None: until Ctrl-C.
    """

    port: int = FIRST_PORT
    browser: bool = True
    seconds: float | None = None


@dataclass(frozen=True, slots=True)
class SimulationSettings:
    """What is simulated.

    Attributes:
        robot: name or file.
        basis: contact basis, as for `tauten serve`.
        model: model that decides, as for `tauten serve`.
        young_scale: the plant's Young's modulus, as a multiple of the robot file's.
        path: that the first effector's target follows, as for `tauten stream`; None: it stays at rest.
    """

    robot: str
    basis: str | None = None
    model: Order | None = None
    young_scale: float = 1.0
    path: str | None = None


def view_simulation(simulation: SimulationSettings, settings: ViewSettings, stop: StopFlag) -> None:
    """Simulate a robot with its controller and show it until a request to stop.

    Raises:
        ViewError: the port is taken.
        PathError: no such path.
        RobotFileError, MeshError, BasisError, StateBasisError: what cannot be used, and why.
    """
    with one_blas_thread():
        with stop.interruptible():
            source, path, file = simulated(simulation)
        with open_server(settings.port, source.look.robot.name) as (server, guard):
            reach = ReachSearch(simulation.robot, simulation.model, simulation.basis)
            session = ViewSession(source, server, guard, file, reach)
            session.arm()
            if path is not None:
                session.follow_path(path)
            announce(server.get_port(), settings.browser)
            try:
                session.run(stop, settings.seconds)
            finally:
                reach.close()


def export_simulation(
    simulation: SimulationSettings,
    seconds: float | None,
    file: Path,
    stop: StopFlag,
    progress: Progress,
) -> int:
    """Simulate a robot that follows a path, into an HTML file; returns the number of frames.

    Args:
        simulation: what is simulated.
        seconds: of the robot; None: one pass of the path.
        file: to write.
        stop: ends it early, with what there is.
        progress: called with the share of each frame.

    Raises:
        PathError: no such path, or none is given.
        RobotFileError, MeshError, BasisError, StateBasisError: what cannot be used, and why.
        OSError: the file cannot be written.
    """
    if simulation.path is None:
        raise PathError("an export of a simulation needs a path: give --path, for instance reach")
    with one_blas_thread():
        with stop.interruptible():
            source, path, _ = simulated(simulation)
        assert path is not None
        duration = path.duration if seconds is None else seconds
        every, rate = _every(source), source.look.robot.rate
        frames = following(source, path, duration, stop)
        shown = _counted(frames, math.ceil(int(duration * rate) / every), progress)
        return write_html(source.look, shown, file)


def simulated(
    simulation: SimulationSettings,
) -> tuple[SimulatedRobot, TargetPath | None, Path | None]:
    """A simulated robot, the path of its target, and the file that cables can be drawn into."""
    log.info("; ".join(filter(None, ("model and simulated robot get ready", waiting()))))
    model = simulation.model
    setup = load_setup(simulation.robot, basis=simulation.basis, model=model)
    loaded = plant_robot(simulation.robot, None, model, simulation.young_scale)
    plant, order = plant_setup(loaded, model)
    path = None
    if simulation.path is not None:
        path = make_path(simulation.path, plant.robot, PathSettings(repeats=True))
    file = Path(simulation.robot)
    own = file.suffix == ".toml" and "parts" not in read_toml(file)
    return SimulatedRobot(setup, plant, order), path, file if own else None


def following(
    source: SimulatedRobot, path: TargetPath, seconds: float, stop: StopFlag
) -> Iterator[ViewFrame]:
    """Frames of a simulated robot whose first effector follows a path.

    Args:
        source: the robot.
        path: of the target.
        seconds: of the robot.
        stop: ends it early.
    """
    robot, every = source.look.robot, _every(source)
    for step in range(int(seconds * robot.rate)):
        if stop.requested:
            return
        goal, first = robot.rest, places_of(robot.effectors)[0]
        goal[first] = path.at(step / robot.rate)
        frame = source.advance(goal, step % every == 0)
        if frame is not None:
            yield frame


def _every(source: SimulatedRobot) -> int:
    """Of how many steps of a simulated robot one gives a frame."""
    return max(round(source.look.robot.rate / FRAMES), 1)


def _counted(frames: Iterator[Frame], count: int, progress: Progress) -> Iterator[Frame]:
    """Frames, of which each but the last is a share of the work; the rest is to write the file."""
    for frame in frames:
        progress(1.0 / (count + 1), "frames")
        yield frame


def view_log(
    log_file: Path,
    settings: ViewSettings,
    stop: StopFlag,
    against: str | None = None,
    recorded_paths: bool = False,
) -> None:
    """Show a log until a request to stop.

    Raises:
        LogError: no log, a damaged one, or one that does not fit the robot.
        ViewError: the port is taken.
        RobotFileError, MeshError, BasisError, StateBasisError: the robot cannot be used.
    """
    with one_blas_thread():
        with stop.interruptible():
            recorded = _recorded(log_file, against, recorded_paths)
        with open_server(settings.port, f"{recorded.look.robot.name}: {log_file.name}") as (
            server,
            guard,
        ):
            session = PlaybackSession(recorded, server, guard)
            announce(server.get_port(), settings.browser)
            session.run(stop, settings.seconds)


def export_log(
    log_file: Path,
    file: Path,
    stop: StopFlag,
    progress: Progress,
    against: str | None = None,
    recorded_paths: bool = False,
) -> int:
    """Write a log's run to an HTML file; returns the number of frames. A stop leaves what there is.

    Raises:
        LogError: no log, a damaged one, or one that does not fit the robot.
        RobotFileError, MeshError, BasisError, StateBasisError: the robot cannot be used.
        OSError: the file cannot be written.
    """
    with one_blas_thread():
        with stop.interruptible():
            recorded = _recorded(log_file, against, recorded_paths)
            count = recorded.count()
        every_tick = _counted(recorded.frames(), count, progress)
        shown = takewhile(lambda _: not stop.requested, every_tick)
        frames = (frame for frame in shown if frame is not None)
        return write_html(recorded.look, frames, file)


def _recorded(log_file: Path, against: str | None, recorded_paths: bool) -> RecordedRobot:
    recorded = RecordedRobot(log_file, against, recorded_paths)
    for note in recorded.notes:
        log.warning("%s: %s", log_file, note)
    return recorded


def view_served(robot: str, network: Network, settings: ViewSettings, stop: StopFlag) -> None:
    """Show a robot that a node serves, until a request to stop; targets go out while *follow* is armed.

    Raises:
        NetworkError: no node, or one of another version.
        ViewError: the port is taken.
    """
    with ExitStack() as stack:
        with stop.interruptible():  # a node that compiles kernels takes minutes to get ready
            session = stack.enter_context(node_of(robot, network))
        source = ServedRobot(session, robot)
        source.await_surface()
        with open_server(settings.port, robot) as (server, guard):
            shown = ViewSession(source, server, guard)
            announce(server.get_port(), settings.browser)
            shown.run(stop, settings.seconds)


def announce(port: int, browser: bool) -> None:
    """Say where the page is, and open it."""
    address = f"http://{HOST}:{port}"
    log.info("open %s in a browser; Ctrl-C ends", address)
    if browser and not webbrowser.open(address):
        log.warning("no browser was found on this computer: open %s yourself", address)
