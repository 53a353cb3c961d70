"""Viewers from start to end: load, open the server, show, close."""

from __future__ import annotations

import logging
import webbrowser
from dataclasses import dataclass

from tauten.model import load_robot
from tauten.service.frames import ServedRobot, SimulatedRobot
from tauten.service.operate import node_of
from tauten.service.process import StopFlag, one_blas_thread
from tauten.service.setup import Order, load_setup
from tauten.service.view.server import FIRST_PORT, HOST, open_server
from tauten.service.view.session import ViewSession, ViewUsage
from tauten.service.wire import Network

log = logging.getLogger(__name__)


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


def view_simulation(
    robot: str,
    settings: ViewSettings,
    stop: StopFlag,
    basis: str | None = None,
    model: Order | None = None,
    young_scale: float = 1.0,
) -> ViewUsage:
    """Simulate a robot with its controller and show it until a request to stop.

    Args:
        robot: name or file.
        settings: of the viewer.
        stop: ends it, before the server runs at once.
        basis: contact basis, as for `tauten serve`.
        model: model that decides, as for `tauten serve`.
        young_scale: the plant's Young's modulus, as a multiple of the robot file's.

    Raises:
        ViewError: the port is taken.
        RobotFileError, MeshError, BasisError, StateBasisError: what cannot be used, and why.
    """
    with one_blas_thread():
        with stop.interruptible():
            setup = load_setup(robot, basis=basis, model=model)
            plant = load_robot(robot, young_scale=young_scale)
            source = SimulatedRobot(setup, plant)
        with open_server(settings.port, plant.name) as (server, guard):
            session = ViewSession(source, server, guard)
            session.arm()
            announce(server.get_port(), settings.browser)
            return session.run(stop, settings.seconds)


def view_served(robot: str, network: Network, settings: ViewSettings, stop: StopFlag) -> ViewUsage:
    """Show a robot that a node serves, until a request to stop; targets go out while *follow* is armed.

    Args:
        robot: name.
        network: of its node.
        settings: of the viewer.
        stop: ends it.

    Raises:
        NetworkError: no node, or one of another version.
        ViewError: the port is taken.
    """
    with node_of(robot, network) as session:
        source = ServedRobot(session, robot)
        source.await_surface()
        with open_server(settings.port, robot) as (server, guard):
            shown = ViewSession(source, server, guard)
            announce(server.get_port(), settings.browser)
            return shown.run(stop, settings.seconds)


def announce(port: int, browser: bool) -> None:
    """Say where the page is, and open it.

    Args:
        port: of the page.
        browser: whether to open the default browser.
    """
    address = f"http://{HOST}:{port}"
    log.info("open %s in a browser; Ctrl-C ends", address)
    if browser and not webbrowser.open(address):
        log.warning("no browser was found on this computer: open %s yourself", address)
