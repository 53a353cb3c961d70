"""Logs of runs as MCAP files: writing and reading."""

from tauten.service.log.reader import (
    LogError,
    Logged,
    LogReader,
    description_metadata,
    logged_description,
)
from tauten.service.log.record import arrived, message_kinds, record_robot
from tauten.service.log.recorder import Entry, LogRecorder

__all__ = [
    "Entry",
    "LogError",
    "LogReader",
    "LogRecorder",
    "Logged",
    "arrived",
    "description_metadata",
    "logged_description",
    "message_kinds",
    "record_robot",
]
