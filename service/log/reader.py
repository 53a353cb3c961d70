"""Reading a log, also one that a crash has cut short.

A log that was not finished is read up to its last whole record. A log whose checksums, lengths or counts
do not match is damaged: its messages are given up to the damage, and then a `LogError` is raised.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from mcap.exceptions import EndOfFile, McapError
from mcap.records import Channel, Footer, McapRecord, Message, Metadata, Statistics
from mcap.stream_reader import StreamReader
from pydantic import ValidationError

from tauten.service.log.recorder import METADATA
from tauten.service.wire import LARGEST_CLOUD, RobotDescription, RunDescription, first_fault

_MAGIC = b"\x89MCAP0\r\n"  # first and last bytes of a finished file
_FRAME = struct.Struct("<BQ")  # kind and length of a record
_DESCRIPTION = "description"  # entry of the metadata
# The recorder writes chunks of 32 KiB and one message more, which may be a cloud; a record cannot decompress
# to more than 255 times its length.
_LARGEST_RECORD = LARGEST_CLOUD + 2**16  # bytes
# What the MCAP library raises on records that make no sense; RuntimeError comes from LZ4.
_DAMAGE = (
    McapError,
    RuntimeError,
    ValueError,
    struct.error,
    LookupError,
    MemoryError,
    OverflowError,
)


class LogError(ValueError):
    """A log that cannot be used; the message names it and the reason."""


@dataclass(frozen=True, slots=True)
class Logged:
    """A message of a log.

    Attributes:
        key: Zenoh key.
        payload: the message.
        encoding: "cdr"; in older logs also "json".
        logged: when it was seen [ns since the epoch].
        sequence: tick it belongs to.
    """

    key: str
    payload: bytes
    encoding: str
    logged: int
    sequence: int


@dataclass(slots=True)
class LogReader:
    """Messages of a log in the order in which they were written.

    Attributes:
        path: the file.
        metadata: facts about the run; known once `messages` has begun.
        complete: whether the file was finished; known once `messages` has ended.
    """

    path: Path
    metadata: dict[str, str] = field(default_factory=dict)
    complete: bool = False

    def messages(self) -> Iterator[Logged]:
        """Read from the start to the end, or to where a crash has cut the file.

        Raises:
            LogError: no such file, not the log of a run, or a damaged one.
        """
        try:
            with self.path.open("rb") as file:
                yield from self._messages(file)
        except OSError as error:
            raise LogError(f"{self.path}: cannot be read ({error.strerror})") from error

    def read_metadata(self) -> dict[str, str]:
        """Facts about the run.

        Raises:
            LogError: as `messages`.
        """
        next(self.messages(), None)
        return self.metadata

    def _messages(self, file: BinaryIO) -> Iterator[Logged]:
        channels: dict[int, Channel] = {}
        count, expected = 0, None
        for record in self._records(file):
            if isinstance(record, Metadata) and record.name == METADATA:
                self.metadata = dict(record.metadata)
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Statistics):
                expected = record.message_count
            elif isinstance(record, Footer):
                self.complete = True
            elif isinstance(record, Message) and self.metadata:
                count += 1
                channel = channels.get(record.channel_id)
                if channel is None:
                    raise LogError(f"{self.path}: damaged: message {count} has no channel")
                key, form = channel.topic.removeprefix("/"), channel.message_encoding
                yield Logged(key, record.data, form, record.log_time, record.sequence)
        if not self.metadata:
            raise LogError(f"{self.path}: not the log of a run")
        if self.complete and expected not in (None, count):
            raise LogError(f"{self.path}: damaged: {count} messages, its summary counts {expected}")

    def _records(self, file: BinaryIO) -> Iterator[McapRecord]:
        """Records up to the end or the cut; without metadata, up to where they make no sense."""
        reader = StreamReader(file, validate_crcs=True, record_size_limit=_LARGEST_RECORD)
        size, finished, whole = _extent(file)
        try:
            yield from reader.records
        except _DAMAGE as error:
            cut = file.tell() == size and (not whole or isinstance(error, EndOfFile))
            if self.metadata and (finished or not cut):
                reason = str(error) or "it ends within a record"
                raise LogError(f"{self.path}: damaged near byte {file.tell()}: {reason}") from error
        else:
            if file.tell() != size:
                raise LogError(f"{self.path}: damaged: it goes on after its end")


def _extent(file: BinaryIO) -> tuple[int, bool, bool]:
    """Size [bytes], whether the file ends as a finished one does, and whether its last record is whole."""
    size = file.seek(0, os.SEEK_END)
    file.seek(max(size - len(_MAGIC), 0))
    finished = size > len(_MAGIC) and file.read() == _MAGIC
    place, end = len(_MAGIC), size - len(_MAGIC) * finished
    while place + _FRAME.size <= end:
        file.seek(place)
        place += _FRAME.size + _FRAME.unpack(file.read(_FRAME.size))[1]
    file.seek(0)
    return size, finished, place == end


def description_metadata(description: RobotDescription) -> dict[str, str]:
    """The entry of a log's metadata that describes its robot, without the surface."""
    return {_DESCRIPTION: description.as_json(surface=False)}


def logged_description(log: Path, metadata: dict[str, str]) -> RunDescription:
    """What the metadata of a log say of the robot of its run.

    Raises:
        LogError: a missing or wrong entry; the message names it.
    """
    if _DESCRIPTION not in metadata:
        raise LogError(f"{log}: its metadata have no {_DESCRIPTION!r}")
    try:
        return RunDescription.model_validate_json(metadata[_DESCRIPTION])
    except ValidationError as error:
        raise LogError(f"{log}: its metadata: {first_fault(error)}") from error
