"""Extras of the package that a command needs and that are not installed."""

from __future__ import annotations

# packages of the extra `viewer`, which the viewer imports
_VIEWER = ("viser", "websockets", "msgspec", "zstandard")


class ExtraError(ImportError):
    """An extra that is not installed."""


def missing_extra(error: ModuleNotFoundError) -> ImportError:
    """What to install for a module that is not found; the error itself for any other module."""
    if (error.name or "").partition(".")[0] not in _VIEWER:
        return error
    return ExtraError(
        f"the viewer needs {error.name}, which is not installed: pip install -e '.[viewer]'"
    )
