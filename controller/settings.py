"""The table `controller` of a robot file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from tauten.model.load import robot_path
from tauten.model.schema import Name, Section, read_toml, validated


class ControllerSettings(Section):
    """Inverse control."""

    qp_solver: Name = Field(
        default="daqp",
        description="Name of the QP library: daqp (default), osqp, proxqp and others, or what an installed "
        "package adds.",
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
        '"full" for pointwise contact, or "none" (default).',
    )
    horizon: Annotated[float, Field(ge=0.0, le=60.0)] = Field(
        default=0.2,
        description="How far decisions look ahead [s], by default 0.2; what leaves is the first tick on the "
        "way. 0: one tick.",
    )
    substeps: Annotated[int, Field(ge=0, le=64)] | None = Field(
        default=None,
        description="Steps of second order that the model takes in a period of control. 0: the step of "
        "implicit Euler that a decision predicts, which damps every motion. By default 1, and 0 for robots "
        "without damping, which would ring.",
    )
    max_pivots: Annotated[int, Field(ge=1, le=1_000_000)] = Field(
        default=100, description="Pieces of the QPCC solved at most in a decision, by default 100."
    )


def controller_settings(contents: dict[str, Any], path: Path) -> ControllerSettings:
    """The settings in a robot file that has been read.

    Args:
        contents: of the file, not validated.
        path: the file, for errors.

    Raises:
        RobotFileError: a field that is not allowed.
    """
    table = contents.get("controller", {})
    if isinstance(table, dict):  # the rate belongs to the model: it is its time step
        table = {key: value for key, value in table.items() if key != "rate"}
    return validated(ControllerSettings, table, path, "controller")


def load_controller_settings(name_or_path: str | Path) -> ControllerSettings:
    """The settings of a shipped robot, by name, or of a robot file.

    Raises:
        RobotFileError: the file, or its table `controller`, cannot be used.
    """
    path = robot_path(name_or_path)
    return controller_settings(read_toml(path), path)
