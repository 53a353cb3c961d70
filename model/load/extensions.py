"""What other packages add to tauten, by a name: entry points of installed packages.

A package registers it in its pyproject.toml, below `[project.entry-points."tauten.drivers"]` for instance.
"""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Any

from tauten.model.schema import RobotFileError


def extension_names(group: str) -> tuple[str, ...]:
    """Names that installed packages register in a group of entry points, sorted."""
    return tuple(sorted({entry.name for entry in entry_points(group=group)}))


def extension(group: str, name: str) -> Any:
    """What an installed package registers by a name; None: nothing.

    Args:
        group: of entry points, such as "tauten.drivers".
        name: in the group.

    Raises:
        RobotFileError: the package cannot be imported.
    """
    for entry in entry_points(group=group, name=name):
        try:
            return entry.load()
        except (ImportError, AttributeError) as error:
            raise RobotFileError(
                f"{name} of the entry points {group}: {entry.value} cannot be imported ({error})"
            ) from error
    return None
