"""The description of a robot in the metadata of a log: as this version writes it, and as earlier ones did."""

from __future__ import annotations

from itertools import zip_longest
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tauten.model.schema import COMPONENTS
from tauten.service.log.reader import LogError
from tauten.service.wire import RobotDescription, RunDescription, first_fault

_ENTRY = "description"
_VERSION = "version "  # begins the entries of versions in earlier logs


def description_metadata(description: RobotDescription) -> dict[str, str]:
    """The entry of a log's metadata that describes its robot, without the surface."""
    return {_ENTRY: description.as_json(surface=False)}


def logged_description(log: Path, metadata: dict[str, str]) -> RunDescription:
    """What a log says of the robot of its run.

    Args:
        log: the file, for messages.
        metadata: as the log has them.

    Raises:
        LogError: a missing or wrong entry; the message names it.
    """
    try:
        if _ENTRY in metadata:
            return RunDescription.model_validate_json(metadata[_ENTRY])
        return RunDescription.model_validate(_of_earlier(log, metadata))
    except ValidationError as error:
        raise LogError(f"{log}: its metadata: {first_fault(error)}") from error


def _of_earlier(log: Path, metadata: dict[str, str]) -> dict[str, Any]:
    """The entries of logs before the description was one of them: each was text by itself."""
    for name in ("robot", "rate", "basis"):
        if name not in metadata:
            raise LogError(f"{log}: its metadata have no {name!r}")
    kinds = metadata.get("effector_kinds", "point").split()
    rows: dict[str, int] = dict(COMPONENTS.items())
    weights = [one.split(",") for one in metadata.get("effector_weights", "").split()]
    return {
        "robot": metadata["robot"],
        "rate": metadata["rate"],
        "start": metadata.get("start", "rest"),
        "actuators": [{"kind": kind} for kind in metadata.get("actuator_kinds", "").split()],
        "effectors": [
            {"kind": kind, "weight": weight or [1.0] * rows.get(kind, 0)}
            for kind, weight in zip_longest(kinds, weights)
        ],
        "model": {
            "order": metadata.get("model", "full"),
            "digest": metadata.get("robot_digest", ""),
            "states": metadata.get("states_digest", ""),
            "factorisation": metadata.get("factorisation", ""),
            "mesh_error": metadata.get("mesh_error", "unknown"),
        },
        "basis": {"name": metadata["basis"], "digest": metadata.get("basis_digest", "")},
        "versions": {
            name.removeprefix(_VERSION): found
            for name, found in metadata.items()
            if name.startswith(_VERSION)
        },
    }
