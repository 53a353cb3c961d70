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
from tauten.reduction.state import (
    ReducedBody,
    ReducedParts,
    StateBasis,
    reduced_parts,
    reduced_robot,
)
from tauten.service.bases import PARTS, load_contact, load_states, part_files, part_states
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
        states: state bases of the reduced model, one for each part that has one; none with the full model.
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
    states: tuple[StateBasis, ...] = ()
    reduced: Robot[ReducedBody | ReducedParts] | None = None
    start: Start = "settled"

    def basis_digest(self) -> str:
        """SHA-256 of the modes; "" without basis."""
        if isinstance(self.contact, str):
            return ""
        return hashlib.sha256(np.ascontiguousarray(self.contact.Psi).tobytes()).hexdigest()

    def states_digest(self) -> str:
        """SHA-256 of the state bases; "" with the full model."""
        digests = [basis.digest() for basis in self.states]
        if len(digests) < 2:
            return "".join(digests)
        return hashlib.sha256("".join(digests).encode()).hexdigest()

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
        return "reduced" if self.states else "full"


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
    files = part_files(contents, path)
    name = basis or controller.basis or (PARTS if files else "none")
    contact = load_contact(loaded, path, name)
    full = Setup(loaded, path, contact, name, controller, kind, service)
    reduced: Robot[ReducedBody | ReducedParts]
    if files:
        order = model or (kind.order if "model" in contents else None)
        bases = part_states(loaded, files, order, accept_error)
        states = tuple(basis for basis in bases if basis is not None)
        if not states:
            return full
        reduced = reduced_parts(loaded, bases)
        allowed = max(basis.origin.tip_max for basis in states)
        kind = kind.model_copy(update={"max_tip_error": max(kind.max_tip_error, allowed)})
    elif (model or kind.order) == "full":
        return full
    else:
        states = (load_states(loaded, path, kind, accept_error),)
        reduced = reduced_robot(loaded, states[0])
    return replace(full, robot=reduced, model=kind, states=states, reduced=reduced)


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
