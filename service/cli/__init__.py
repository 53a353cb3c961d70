"""The `tauten` command, a file a group of commands."""

from tauten.service.cli.app import main

__all__ = ["main"]
