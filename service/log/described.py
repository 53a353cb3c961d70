"""The description of a robot in the metadata of a log."""

from __future__ import annotations

from pathlib import Path

from pydantic import ValidationError

from tauten.service.log.reader import LogError
from tauten.service.wire import RobotDescription, RunDescription, first_fault

_ENTRY = "description"


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
    if _ENTRY not in metadata:
        raise LogError(f"{log}: its metadata have no {_ENTRY!r}")
    try:
        return RunDescription.model_validate_json(metadata[_ENTRY])
    except ValidationError as error:
        raise LogError(f"{log}: its metadata: {first_fault(error)}") from error
