"""The commands below `tauten bench`, a file a group of commands."""

from tauten.service.cli.bench.app import bench

__all__ = ["bench"]
