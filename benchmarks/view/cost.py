"""What showing a robot costs: pictures a second, processor share, time of a picture."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from multiprocessing import get_context
from multiprocessing.synchronize import Event

import numpy as np
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from tauten.model import one_blas_thread
from tauten.service.frames import FrameHistory, RobotLook, TargetStore, ViewFrame
from tauten.service.link import HOST
from tauten.service.node import Clock
from tauten.service.plant import PathError
from tauten.service.process import HostInfo, StopFlag, host_info
from tauten.service.replay import Spread, spread
from tauten.service.view import (
    SPAN,
    TRAIL,
    RobotScene,
    SimulationSettings,
    ViewPanel,
    following,
    open_server,
    simulated,
)

_RATE = 30.0  # pictures a second
_PLOTS = 6  # pictures between two updates of the plots
_CONNECT = 60.0  # s
_MOTION = 1.0  # s of the robot that are shown again and again


@dataclass(frozen=True, slots=True)
class ViewCost:
    """Measured cost of showing a robot to one client, without what moves it.

    Attributes:
        machine: where.
        robot: name.
        nodes: of the robot.
        vertices: of the skin.
        triangles: of the skin.
        seconds: of pictures.
        pictures_hz: pictures a second; 30 are wanted.
        processor_share: processor time of the process over time.
        picture_ms: time of a picture in the loop.
    """

    machine: HostInfo
    robot: str
    nodes: int
    vertices: int
    triangles: int
    seconds: float
    pictures_hz: float
    processor_share: float
    picture_ms: Spread


def simulation_cost(
    simulation: SimulationSettings, seconds: float, stop: StopFlag
) -> ViewCost | None:
    """What showing a simulated robot costs; None when stopped before there were numbers.

    Args:
        simulation: what is simulated; its path moves the robot.
        seconds: of pictures.
        stop: ends it early.

    Raises:
        PathError: no such path, or none is given.
        RobotFileError, MeshError, BasisError, StateBasisError: what cannot be used, and why.
    """
    with one_blas_thread():
        with stop.interruptible():
            source, path, _ = simulated(simulation)
        if path is None:
            raise PathError("a benchmark of the viewer needs a path: give --path")
        frames = list(following(source, path, min(path.duration, _MOTION), stop))
        if not frames:
            return None
        return view_cost(source.look, source.nodes, frames, seconds, stop)


def view_cost(
    look: RobotLook, nodes: int, frames: Sequence[ViewFrame], seconds: float, stop: StopFlag
) -> ViewCost | None:
    """Show frames again and again to one client in a process of its own.

    Args:
        look: of the robot.
        nodes: of the robot.
        frames: at least one.
        seconds: of pictures.
        stop: ends it early.

    Returns:
        The numbers; None when stopped before there were any.

    Raises:
        OSError: the client does not connect.
    """
    context = get_context("spawn")
    targets = TargetStore(look.robot.effectors, look.robot.size)
    with open_server(0, look.robot.name) as (server, guard):
        panel, scene = ViewPanel(server, look, targets), RobotScene(server, look, True)
        done = context.Event()
        client = context.Process(target=_receive, args=(server.get_port(), done), daemon=True)
        client.start()
        try:
            end = time.monotonic() + _CONNECT
            while guard.browsers == 0:
                if time.monotonic() > end or not client.is_alive():
                    raise OSError("the client of the benchmark does not connect")
                time.sleep(0.05)
            times: list[float] = []
            history = FrameHistory(whole=False)
            clock, begin, processor = Clock(1.0 / _RATE), time.monotonic(), time.process_time()
            while time.monotonic() - begin < seconds and not stop.requested:
                clock.wait()
                start = time.perf_counter()
                count = len(times)
                frame = _at(frames[count % len(frames)], count / _RATE)
                history.add(frame)
                with server.atomic():
                    scene.draw(frame, history.between(frame.time - TRAIL, frame.time))
                if count % _PLOTS == 0:
                    panel.charts.draw(history.between(frame.time - SPAN, frame.time))
                    panel.show_time(history.first, history.last, frame.time)
                times.append(time.perf_counter() - start)
            lasted = time.monotonic() - begin
            share = (time.process_time() - processor) / lasted
        finally:
            done.set()
            client.join(5.0)
            client.kill()
    if not times:
        return None
    return ViewCost(
        machine=host_info(),
        robot=look.robot.name,
        nodes=nodes,
        vertices=len(look.vertices),
        triangles=len(look.robot.surface.triangles),
        seconds=lasted,
        pictures_hz=len(times) / lasted,
        processor_share=share,
        picture_ms=spread(list(1e3 * np.array(times))),
    )


def _at(frame: ViewFrame, time_: float) -> ViewFrame:
    """The frame at another time [s]."""
    return replace(frame, time=time_)


def _receive(port: int, done: Event) -> None:
    """Receive what a browser would, until the benchmark is over."""
    with connect(
        f"ws://{HOST}:{port}",
        origin=Origin(f"http://{HOST}:{port}"),
        subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
        compression=None,
        max_size=None,
    ) as connection:
        while not done.is_set():
            try:
                connection.recv(timeout=0.5)
            except TimeoutError:
                continue
            except ConnectionClosed:
                return
