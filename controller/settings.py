"""The tables `controller` and `model` of a robot file, and the settings of decisions from them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field

from tauten.controller.planning import FRICTION_SHARE, DecideSettings
from tauten.controller.qpcc import Backend, QpccSettings, qp_backend
from tauten.model import (
    ContactSpace,
    Enrichment,
    ForceLimits,
    Robot,
    RobotFileError,
    force_limits,
    of_kind,
)
from tauten.model.body import LIGHT_DAMPING, damping_ratios, natural_frequencies
from tauten.model.load import robot_path
from tauten.model.numerics import FactorisationError
from tauten.model.schema import (
    ControlPeriod,
    Name,
    Positive,
    Rate,
    Section,
    in_range,
    read_toml,
    validated,
)

VIBRATIONS = 6  # the lowest ones, which are looked at


class ControllerSettings(Section):
    """Inverse control."""

    qp_solver: Name = Field(
        default="daqp",
        description="Name of the QP library, or what an installed package adds. daqp (default) is the "
        "fastest; with quadprog and osqp nearly all decisions end OK, too, more slowly; with clarabel, "
        "cvxopt, piqp and proxqp many do not (docs/qpcc.md has the shares).",
    )
    regularisation: Annotated[float, Field(ge=0.0, le=1e6)] = Field(
        default=1e-6,
        description="Weight of the energy of the actuators against the distance to the target, unitless, by "
        "default 1e-6: it selects among efforts that are equally good, and holds a robot back from a target "
        "in reach by a part of the way that is of its order.",
    )
    basis: str | None = Field(
        default=None,
        description="Contact basis of the controller: a .basis file beside the robot file, a shipped one, "
        '"full" for pointwise contact, or "none"; by default "full" where the file has obstacles, and else '
        '"none", with which decisions know no contact. Of a robot of parts the default are the bases of the '
        "parts, and full contact between them.",
    )
    horizon: Annotated[float, Field(ge=0.0, le=60.0)] = Field(
        default=0.2,
        description="How far decisions look ahead [s], by default 0.2; what leaves is the first tick on the "
        "way. 0: one tick.",
    )
    following_horizon: Annotated[float, Field(ge=0.0, le=60.0)] | None = Field(
        default=None,
        description="How far decisions look ahead at least [s] where effectors follow targets that move. By "
        "default motion goes on where no contact is in range; elsewhere arms that take longer than a tick "
        "to come to rest are late by about `horizon`; with this they are late by about this everywhere.",
    )
    substeps: Annotated[int, Field(ge=0, le=64)] | None = Field(
        default=None,
        description="Steps of second order that the model takes in a period of control. 0: the step of "
        "implicit Euler that a decision predicts, which damps every motion. By default 1, and 0 for robots "
        "without damping, or with less than 5 % of critical damping in vibrations that are faster than the "
        "horizon: decisions would keep these swinging.",
    )
    friction_share: Annotated[float, Field(gt=0.0, le=1.0)] | None = Field(
        default=None,
        description="Share of the coefficients of friction that decisions count on. By default 0.66, and 1 "
        "of a robot whose file holds all of it, which touches nothing but itself and obstacles and has no "
        "limits of contact forces. A decision that counts on all of it squeezes to the border of the cone, "
        "and a little less friction or more weight than the file says lets the object slip. A grasp holds an "
        "object that has 20 % less friction and 20 % more mass than the file says where the share is less "
        "than 0.8 / 1.2.",
    )
    max_pivots: Annotated[int, Field(ge=1, le=1_000_000)] = Field(
        default=100,
        description="Pieces of the QPCC solved at most in a decision, by default 100; with friction twice as "
        "many linear systems.",
    )


class ControllerTable(ControllerSettings, ControlPeriod):
    """The table `controller`, which model and controller read: the rate is the time step of the model."""

    model_config = ConfigDict(extra="forbid")


class ModelSettings(Section):
    """Which model decides: the full one, or that of a state basis with its sample of elements.

    While serving, the full model computes at intervals how far it would move the tip from where the reduced
    one has it. Where this exceeds `max_tip_error`, health warns, and with `fall_back` the full model takes
    over.
    """

    order: Literal["full", "reduced"] = Field(
        default="full", description="Which model, by default full."
    )
    states: str | None = Field(
        default=None,
        description="Name of the state basis, a .states file beside the robot file or a shipped one; by "
        "default the robot's name.",
    )
    max_tip_error: Annotated[Positive, in_range(0.0, 10.0, "m")] = Field(
        default=1e-3,
        description="Error of the tip that a reduced model may have [m], by default 1e-3.",
    )
    check_period: Annotated[Positive, in_range(1e-3, 3600.0, "s")] = Field(
        default=1.0,
        description="Time between two comparisons with the full model [s], by default 1.",
    )
    fall_back: bool = Field(
        default=False,
        description="Whether the full model replaces a reduced one that exceeds `max_tip_error`; by default "
        "not.",
    )
    fall_back_rate: Rate = Field(
        default=50.0, description="Control rate of the full model then [Hz], by default 50."
    )


def controller_settings(contents: dict[str, Any], path: Path) -> ControllerSettings:
    """The settings in a robot file that has been read.

    Raises:
        RobotFileError: a field that is not allowed.
    """
    table = validated(ControllerTable, contents.get("controller", {}), path, "controller")
    try:
        qp_backend(table.qp_solver)
    except RobotFileError as error:
        raise RobotFileError(f"{path}: controller.qp_solver: {error}") from None
    return ControllerSettings(**table.model_dump(exclude={"rate"}, exclude_unset=True))


def load_controller_settings(name_or_path: str | Path) -> ControllerSettings:
    """The settings of a shipped robot, by name, or of a robot file.

    Raises:
        RobotFileError: the file, or its table `controller`, cannot be used.
    """
    path = robot_path(name_or_path)
    return controller_settings(read_toml(path), path)


def load_model_settings(name_or_path: str | Path) -> ModelSettings:
    """The table `model` of a shipped robot's file, by name, or of a robot file.

    Raises:
        RobotFileError: the file, or its table `model`, cannot be used.
    """
    path = robot_path(name_or_path)
    return validated(ModelSettings, read_toml(path).get("model", {}), path, "model")


def checked_settings(given: ControllerSettings | None) -> ControllerSettings:
    """What is given, or a bare file's for None; a TypeError where it is something else."""
    return ControllerSettings() if given is None else of_kind("settings", given, ControllerSettings)


def decide_settings(
    given: ControllerSettings, robot: Robot, space: ContactSpace, enrichment: Enrichment,
    qp: Backend | None,
) -> DecideSettings:  # fmt: skip
    """The settings of a robot's decisions; where there is no QP library of the name, a RobotFileError."""
    solver = given.qp_solver if qp is None else qp
    qp_backend(solver)
    forces = force_limits(robot.contacts, space)
    return DecideSettings(
        epsilon=given.regularisation,
        enrichment=enrichment,
        qpcc=QpccSettings(solver, given.max_pivots),
        substeps=substeps_of(robot, given),
        friction_share=share_of_friction(robot, given, forces),
        forces=forces,
    )


def share_of_friction(
    robot: Robot, settings: ControllerSettings, forces: ForceLimits | None
) -> float:
    """The share of the coefficients of friction that decisions count on.

    All of it where friction holds nothing: plans that count on less expect a robot that sticks to slide, and
    it rests where they lead, beside the best place.

    Args:
        robot: the robot.
        settings: of its file.
        forces: limits of its contact forces; None: there are none.
    """
    if settings.friction_share is not None:
        return settings.friction_share
    holds = robot.floats or robot.contacts.loose or forces is not None
    return FRICTION_SHARE if holds else 1.0


def substeps_of(robot: Robot, settings: ControllerSettings) -> int:
    """How many steps of second order the model takes in a tick; 0: the decision's own step.

    Nothing but the decision's step of implicit Euler damps a robot without damping: it would ring for ever,
    and one with light damping as long as decisions give its vibrations more than damping takes. Where the
    step of a quasi-static robot leads does not depend on its length.

    Args:
        robot: the robot.
        settings: of its file.
    """
    if robot.integration.static:
        return 0
    if settings.substeps is not None:
        return settings.substeps
    if not robot.integration.damped:
        return 0
    parts = robot.body.part_robots or (robot,)
    return int(not any(lightly_damped(part, settings.horizon) for part in parts))


def lightly_damped(robot: Robot, horizon: float) -> bool:
    """Whether decisions keep some vibration of a robot swinging because its damping is light.

    Plans see vibrations that take longer than 2π horizons, and slow them down; those of less than two ticks
    are damped by the steps of the model. Where one of two springs goes slack, half of the stiffness is left.
    Frequencies are looked for only where some between would be damped lightly.

    Args:
        robot: of one part.
        horizon: of its plans [s].
    """
    scheme = robot.integration
    if scheme.static or scheme.viscous:
        return False
    band = 0.5 / (np.pi * max(horizon, scheme.h)), 0.5 * scheme.rate  # Hz
    a, b = scheme.rayleigh_mass, scheme.rayleigh_stiffness
    least = np.clip(np.sqrt(a / b) / (2.0 * np.pi) if b > 0.0 else np.inf, *band)
    if damping_ratios(scheme, np.array([*band, least])).min() >= LIGHT_DAMPING:
        return False
    rest = robot.rest()
    springs = robot.spring_rows(rest)
    try:
        found = natural_frequencies(robot.body, rest, VIBRATIONS, springs)
    except FactorisationError:  # nothing but contact or cables without springs hold it
        return False
    fastest = band[1] * (np.sqrt(2.0) if len(springs) > 0 else 1.0)
    between = found[(found > band[0]) & (found < fastest)]
    return bool((damping_ratios(scheme, between) < LIGHT_DAMPING).any())
