"""The commands of `python -m benchmarks`, a file a group of commands."""

from benchmarks.commands.app import app

__all__ = [
    "app",
]
