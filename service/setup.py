"""From names on the command line to a robot with its contact basis and a warm controller."""

from __future__ import annotations

import hashlib
import logging
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np

from tauten.controller import Controller, ControllerSettings, controller_settings
from tauten.controller.qpcc import warm_solver
from tauten.model import Report, Robot
from tauten.model.load import make_robot, robot_path
from tauten.model.schema import Changes, read_toml, validated
from tauten.reduction import ContactBasis
from tauten.reduction.contact import SUFFIX as BASIS
from tauten.reduction.state import SUFFIX as STATES
from tauten.reduction.state import ReducedBody, StateBasis, reduced_robot
from tauten.service.check import mesh_error_text
from tauten.service.settings import ModelSettings, ServiceSettings

log = logging.getLogger(__name__)

Order: TypeAlias = Literal["full", "reduced"]
Start: TypeAlias = Literal["settled", "rest"]

_WARM_UP = 12  # control steps; enough for every kernel to be compiled or loaded


@dataclass(frozen=True, slots=True)
class Setup:
    """All that a controller is made from.

    Attributes:
        robot: the robot.
        path: its file.
        contact: contact of the controller: a basis, "full" for pointwise contact, or "none".
        basis_name: as given on the command line or in the robot file.
        controller: settings of its decisions.
        model: settings of the model that decides.
        service: settings of the node.
        states: state basis of the reduced model; None with the full one.
        reduced: the robot, where it is a reduced model.
        start: whether the model starts from the equilibrium under its loads with the actuators at rest, or
            from rest, undeformed.
    """

    robot: Robot
    path: Path
    contact: Literal["none", "full"] | ContactBasis
    basis_name: str
    controller: ControllerSettings
    model: ModelSettings
    service: ServiceSettings
    states: StateBasis | None = None
    reduced: Robot[ReducedBody] | None = None
    start: Start = "settled"

    def basis_digest(self) -> str:
        """SHA-256 of the modes; "" without basis."""
        if isinstance(self.contact, str):
            return ""
        return hashlib.sha256(np.ascontiguousarray(self.contact.Psi).tobytes()).hexdigest()

    @property
    def basis_modes(self) -> int:
        """Number of modes of the contact basis; 0 without one."""
        return 0 if isinstance(self.contact, str) else self.contact.k

    @property
    def mesh_error(self) -> str:
        """The error of the robot's mesh in one sentence."""
        return mesh_error_text(self.path, self.robot.digest)

    @property
    def order(self) -> Order:
        """The model that decides."""
        return "full" if self.states is None else "reduced"


def load_setup(
    robot: str | Path,
    rate: float | None = None,
    basis: str | None = None,
    model: Order | None = None,
    accept_error: bool = False,
    young_scale: float = 1.0,
) -> Setup:
    """Load a robot, its contact basis, and its state basis where the model is reduced.

    Args:
        robot: name of a shipped robot or path of a robot file.
        rate: another control rate than the file's [Hz].
        basis: another basis than the file's; "none" for no contact, "full" for pointwise contact.
        model: another model than the file's.
        accept_error: accept a state basis with a larger error than the robot file allows.
        young_scale: of Young's modulus; a robot of another stiffness than the file's has no state basis.

    Raises:
        RobotFileError: the robot file cannot be used.
        MeshError: its mesh cannot be used.
        BasisError: its contact basis cannot be used.
        StateBasisError: its state basis cannot be used.
    """
    path = robot_path(robot)
    contents = read_toml(path)
    changes = validated(Changes, {"rate": rate, "young_scale": young_scale}, f"{path}: load_setup")
    controller = controller_settings(contents, path)
    kind = validated(ModelSettings, contents.get("model", {}), path, "model")
    service = validated(ServiceSettings, contents.get("service", {}), path, "service")
    loaded = make_robot(contents, path, changes)
    name = basis or controller.basis or "none"
    contact = load_contact(loaded, path, name)
    if (model or kind.order) == "full":
        return Setup(loaded, path, contact, name, controller, kind, service)
    states = load_states(loaded, path, kind, accept_error)
    reduced = reduced_robot(loaded, states)
    return Setup(reduced, path, contact, name, controller, kind, service, states, reduced)


def interpolated(setup: Setup, delay: float) -> Setup:
    """A setup whose node follows targets on straight lines between them.

    Args:
        setup: as loaded.
        delay: with which they are followed [s]; 0: the latest target is followed.

    Raises:
        RobotFileError: the delay is not allowed.
    """
    service = setup.service.model_dump() | {"interpolation_delay": delay}
    return replace(setup, service=validated(ServiceSettings, service, "--interpolate"))


def load_contact(robot: Robot, path: Path, name: str) -> Literal["none", "full"] | ContactBasis:
    """Contact of a controller by name: "none", "full", or a basis that fits the robot.

    Args:
        robot: the robot.
        path: its file.
        name: of the basis, or of its file beside the robot file, with or without ".basis".

    Raises:
        BasisError: there is no such basis, or it was made for another robot.
    """
    if name == "none":
        return "none"
    if name == "full":
        return "full"
    found = ContactBasis.load(beside(path, name, BASIS))
    found.check_robot(robot)
    return found


def load_states(
    robot: Robot, path: Path, settings: ModelSettings, accept_error: bool
) -> StateBasis:
    """The state basis that the robot file at `path` names, or that of the robot's name beside it or shipped.

    Args:
        robot: the robot.
        path: its file.
        settings: the table `model` of the file.
        accept_error: accept a larger error than the robot file allows.

    Raises:
        StateBasisError: there is none, it was made for another robot, or its error is larger than allowed.
    """
    states = StateBasis.load(beside(path, settings.states or robot.name, STATES))
    states.check_robot(robot)
    if not accept_error:
        states.check_tip(settings.max_tip_error)
    return states


def beside(path: Path, name: str, suffix: str) -> Path | str:
    """The file of this name in the folder of the robot file, where there is one; else the name.

    Args:
        path: the robot file.
        name: of the file wanted, with or without its suffix.
        suffix: of such files.
    """
    for file in (path.parent / name, path.parent / f"{name}{suffix}"):
        if file.is_file():
            return file
    return name


def warm_controller(setup: Setup) -> Controller:
    """A controller at the setup's start, with every kernel it needs compiled.

    A robot sags under its weight before it is served, and so does the model: it would fall otherwise. Where
    no equilibrium is found it starts from rest, and the log says so.

    It first follows a target a tenth of the robot's size away, so that the first real step is as
    fast as the others.
    """
    controller = Controller(setup.robot, setup.contact, settings=setup.controller)
    if setup.start == "settled":
        report = controller.settle_start()
        if not report.converged:
            log.warning("%s", start_at_rest(setup.robot, report))
    return warm_up(controller)


def start_at_rest(robot: Robot, report: Report) -> str:
    """Why a robot whose search for an equilibrium ended so starts from rest, in one sentence."""
    return (
        f"the model of {robot.name} starts undeformed and moves at first: it finds no equilibrium under its "
        f"loads in {report.iterations} steps, {report.ending.value}"
    )


def warm_up(controller: Controller) -> Controller:
    """The controller back at its start, after steps enough for every kernel it needs to be compiled."""
    warm_solver(controller.settings.qpcc.solver)
    away = controller.shifted(0.1 * controller.robot.size / np.sqrt(3.0))
    for _ in range(_WARM_UP):
        controller.step(away)
    controller.hold()
    controller.advance()
    controller.reset()
    controller.prepare()
    return controller
