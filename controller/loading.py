"""What a controller is made from: a robot file with the bases and settings that it names."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

from tauten.controller.bases import PARTS, load_contact, load_states, part_files, part_states
from tauten.controller.settings import ControllerSettings, ModelSettings, controller_settings
from tauten.model import Robot
from tauten.model.load import make_robot
from tauten.model.schema import Changes, RobotFileError, validated
from tauten.reduction import ContactBasis
from tauten.reduction.state import (
    ReducedBody,
    ReducedParts,
    StateBasis,
    reduced_parts,
    reduced_robot,
)

Order: TypeAlias = Literal["full", "reduced"]
Start: TypeAlias = Literal["settled", "rest"]


@dataclass(frozen=True, slots=True)
class ControllerSetup:
    """All that a controller is made from.

    Attributes:
        robot: the robot.
        path: its file.
        contact: contact of the controller: a basis, "full" for pointwise contact, or "none".
        basis_name: as given by the caller or in the robot file.
        controller: settings of its decisions.
        model: settings of the model that decides.
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
    states: tuple[StateBasis, ...] = ()
    reduced: Robot[ReducedBody | ReducedParts] | None = None
    start: Start = "settled"


def controller_setup(
    contents: dict[str, Any],
    path: Path,
    rate: float | None = None,
    basis: str | None = None,
    model: Order | None = None,
    accept_error: bool = False,
    young_scale: float = 1.0,
) -> ControllerSetup:
    """Make a robot, its contact basis, and its state basis where the model is reduced.

    Args:
        contents: of the robot file, not validated.
        path: the file, for errors and for files beside it.
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
        ValueError: there is no such model.
    """
    if model not in (None, *get_args(Order)):
        raise ValueError(f"model: found {model!r}, expected one of {', '.join(get_args(Order))}")
    changes = validated(Changes, {"rate": rate, "young_scale": young_scale}, f"{path}: load_setup")
    controller = controller_settings(contents, path)
    kind = validated(ModelSettings, contents.get("model", {}), path, "model")
    loaded = make_robot(contents, path, changes)
    files = part_files(contents, path)
    alone = "full" if loaded.obstacles.obstacles else "none"  # obstacles are there to be touched
    name = basis or controller.basis or (PARTS if files else alone)
    contact = load_contact(loaded, path, name)
    full = ControllerSetup(loaded, path, contact, name, controller, kind)
    reduced: Robot[ReducedBody | ReducedParts]
    if files:
        given = kind.model_fields_set
        if "states" in given:
            raise RobotFileError(
                f"{path}: model.states: state bases stand in the files of the parts"
            )
        order = model or (kind.order if "order" in given else None)
        bases = part_states(loaded, files, order, accept_error)
        states = tuple(basis for basis in bases if basis is not None)
        if not states:
            return full
        reduced = reduced_parts(loaded, bases)
        if "max_tip_error" not in given:
            allowed = max(basis.origin.tip_max for basis in states)
            kind = kind.model_copy(update={"max_tip_error": max(kind.max_tip_error, allowed)})
        elif not accept_error:
            for states_of_part in states:
                states_of_part.check_tip(kind.max_tip_error)
    elif (model or kind.order) == "full":
        return full
    else:
        states = (load_states(loaded, path, kind, accept_error),)
        reduced = reduced_robot(loaded, states[0])
    return replace(full, robot=reduced, model=kind, states=states, reduced=reduced)
