"""Contact bases and state bases that robot files name."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

from tauten.controller.settings import ModelSettings, load_controller_settings, load_model_settings
from tauten.model import Robot
from tauten.model.constraints import ConstrainedBody
from tauten.model.load import command_name, part_path
from tauten.model.schema import read_toml
from tauten.reduction import BasisError, ContactBasis
from tauten.reduction.contact import SUFFIX as BASIS
from tauten.reduction.contact import joined_basis
from tauten.reduction.state import SUFFIX as STATES
from tauten.reduction.state import StateBasis, StateBasisError

PARTS = "parts"  # instead of a basis: those of the parts


def load_contact(robot: Robot, path: Path, name: str) -> Literal["none", "full"] | ContactBasis:
    """Contact of a controller by name: "none", "full", "parts", or a basis that fits the robot.

    Args:
        robot: the robot.
        path: its file.
        name: of the basis, or of its file beside the robot file, with or without ".basis"; "parts" are those
            that the files of a robot's parts name.

    Raises:
        BasisError: there is no such basis, or it was made for another robot.
    """
    if name == "none":
        return "none"
    if name == "full":
        return "full"
    if name == PARTS and robot.body.part_robots:
        return parts_contact(robot, path)
    found = beside(path, name, BASIS)
    try:
        basis = ContactBasis.load(found)
    except BasisError as error:
        raise BasisError(f"{error}{_or_beside(found, path, BASIS)}") from error
    try:
        return basis.fitted(robot)
    except BasisError as error:
        raise BasisError(f"{found}: {error}") from error


def load_states(
    robot: Robot, path: Path, settings: ModelSettings, accept_error: bool
) -> StateBasis:
    """The state basis that the robot file at `path` names, or that of the robot's name beside it or shipped.

    Raises:
        StateBasisError: there is none, it was made for another robot, or its error is larger than allowed.
    """
    found = beside(path, settings.states or robot.name, STATES)
    try:
        states = StateBasis.load(found)
    except StateBasisError as error:
        raise StateBasisError(f"{error}{_or_beside(found, path, STATES)}") from error
    try:
        states.check_robot(robot)
        if not accept_error:
            states.check_tip(settings.max_tip_error)
    except StateBasisError as error:
        raise StateBasisError(f"{found}: {error}") from error
    return states


def beside(path: Path, name: str, suffix: str) -> Path | str:
    """The file of this name in the folder of the robot file, where there is one; else the name.

    Where the robot file is a link, the folder of the link comes before that of the file that it leads to.
    """
    for folder in dict.fromkeys((path.parent, Path(os.path.realpath(path)).parent)):
        for file in (folder / name, folder / f"{name}{suffix}"):
            if file.is_file():
                return file
    return name


def _or_beside(found: Path | str, path: Path, suffix: str) -> str:
    """The file that could have had the name of a missing basis, and what makes one; "" of a path."""
    if isinstance(found, Path) or found.endswith(suffix):
        return ""
    states = " --states" * (suffix == STATES)
    makes = f"`tauten reduce {command_name(path)}{states}` makes one"
    return f"; no file {found}{suffix} is beside {path} either; {makes}"


def part_files(contents: dict[str, Any], path: Path) -> list[Path]:
    """The robot files of the parts of a robot; none where it has no parts.

    Args:
        contents: of the robot file, of a robot that has been made of it.
        path: the file.
    """
    return [part_path(part["robot"], path) for part in contents.get(PARTS, ())]


def parts_contact(robot: Robot, path: Path) -> Literal["none", "full"] | ContactBasis:
    """Contact of a robot of parts: the bases that their files name, and unit columns for all else.

    Raises:
        BasisError: a basis was made for another robot than that of its part.
    """
    if robot.n_c == 0:
        return "none"
    bases = []
    for part, file in zip(robot.body.part_robots, part_files(read_toml(path), path), strict=True):
        name = load_controller_settings(file).basis or "none"
        found = load_contact(part, file, name)
        bases.append(None if isinstance(found, str) else found)
    return joined_basis(robot, bases) or "full"


def is_rigid(robot: Robot) -> bool:
    """Whether all nodes of a robot are of rigid regions, so that there is nothing to reduce."""
    body = robot.body
    return (
        isinstance(body, ConstrainedBody)
        and body.joints is None
        and len(body.coordinates.free) == 0
    )


def part_states(
    robot: Robot,
    files: Sequence[Path],
    order: Literal["full", "reduced"] | None,
    accept_error: bool,
) -> list[StateBasis | None]:
    """The state basis of each part of a robot; None where its model is the full one, and of rigid objects.

    Raises:
        StateBasisError: a part has none, or one with a larger error than its file allows.
    """
    found: list[StateBasis | None] = []
    for part, file in zip(robot.body.part_robots, files, strict=True):
        settings = load_model_settings(file)
        if (order or settings.order) == "full" or is_rigid(part):
            found.append(None)
        else:
            found.append(load_states(part, file, settings, accept_error))
    return found
