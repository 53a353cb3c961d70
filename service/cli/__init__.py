"""The `tauten` command, a file a group of commands."""

from tauten.service.cli.entry import main, run

__all__ = ["main", "run"]
