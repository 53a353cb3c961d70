"""How a controller starts: settled under its loads, with its kernels compiled."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np

from tauten.controller.controller import Controller
from tauten.controller.friction import warm_search
from tauten.controller.loading import ControllerSetup, Order, controller_setup
from tauten.controller.qpcc import warm_solver
from tauten.model import Report, Robot, Simulator, default_enrichment, one_blas_thread
from tauten.model.load import robot_path
from tauten.model.numerics import Array
from tauten.model.schema import read_toml

log = logging.getLogger(__name__)

_WARM_UP = 12  # control steps; enough for every kernel to be compiled or loaded


def started_controller(robot: str | Path, model: Order | None, contact: str | None) -> Controller:
    """The controller of a robot file, as a node starts it."""
    with one_blas_thread():
        return warm_controller(_setup_of(robot, model, contact))


def started_simulator(robot: str | Path, model: Order | None, contact: str | None) -> Simulator:
    """The simulator of a robot file, settled under its loads where the file does not say otherwise."""
    setup = _setup_of(robot, model, contact)
    checked = None if isinstance(setup.contact, str) else default_enrichment(setup.robot.tolerance)
    simulator = Simulator(setup.robot, setup.contact, checked)
    _settle_start(simulator, setup)
    return simulator


def warm_controller(setup: ControllerSetup) -> Controller:
    """A controller at the setup's start, with every kernel it needs compiled.

    A robot sags under its weight before it is served, and so does the model: it would fall otherwise. Where
    no equilibrium is found it starts from rest, and the log says so.

    It first follows a target a tenth of the robot's size away, so that the first real step is as
    fast as the others.
    """
    controller = Controller(setup.robot, setup.contact, settings=setup.controller)
    _settle_start(controller, setup)
    return warm_up(controller)


def _setup_of(robot: str | Path, model: Order | None, contact: str | None) -> ControllerSetup:
    """The setup of a robot file; the arguments are those of `started_controller`."""
    path, basis = robot_path(robot), None if contact is None else str(contact)
    return controller_setup(read_toml(path), path, basis=basis, model=model)


def _settle_start(model: Controller | Simulator, setup: ControllerSetup) -> None:
    """Start from the equilibrium, where the file does not say otherwise; the log says where there is none."""
    if setup.start == "settled":
        report = model.settle_start()
        if not report.converged:
            log.warning("%s", start_at_rest(setup.robot, report))


def start_at_rest(robot: Robot, report: Report) -> str:
    """Why a robot whose search for an equilibrium ended so starts from rest, in one sentence."""
    return (
        f"the model of {robot.name} starts undeformed and moves at first: it finds no equilibrium under its "
        f"loads in {report.iterations} steps, {report.ending.value}"
    )


def target_beside(controller: Controller) -> Array:
    """Goal values (n_v,) a tenth of the robot's size away, which take actuators far from rest."""
    return controller.shifted(0.1 * controller.robot.size / np.sqrt(3.0))


def warm_up(controller: Controller) -> Controller:
    """The controller back at its start, after steps enough for every kernel it needs to be compiled."""
    warm_solver(controller.settings.qpcc.solver)
    if controller.robot.contacts.frictional:
        warm_search()
    away = target_beside(controller)
    for _ in range(_WARM_UP):
        controller.step(away)
    controller.hold()
    controller.advance()
    controller.reset()
    controller.prepare()
    return controller
