"""Reading a log back, also one that a crash has cut short."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from mcap.exceptions import McapError
from mcap.records import Channel, Footer, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader

from tauten.service.log.recorder import METADATA


class LogError(ValueError):
    """A log that cannot be used; the text says which and why."""


@dataclass(frozen=True, slots=True)
class Logged:
    """A message of a log.

    Attributes:
        key: Zenoh key.
        payload: as it went over the wire.
        encoding: "cdr" or "json".
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
    """Messages of a log in the order they were written.

    Attributes:
        path: the file.
        metadata: what the run was; there once `messages` has begun.
        complete: whether the file was finished; known once `messages` has ended.
    """

    path: Path
    metadata: dict[str, str] = field(default_factory=dict)
    complete: bool = False

    def messages(self) -> Iterator[Logged]:
        """Read from the start to the end, or to where a crash has cut the file.

        Raises:
            LogError: no such file, not an MCAP file, or not one of ours.
        """
        try:
            with self.path.open("rb") as file:
                yield from self._records(StreamReader(file))
        except OSError as error:
            raise LogError(f"{self.path}: cannot be read ({error.strerror})") from error

    def read_metadata(self) -> dict[str, str]:
        """What the run was.

        Raises:
            LogError: as `messages`.
        """
        next(self.messages(), None)
        return self.metadata

    def _records(self, reader: StreamReader) -> Iterator[Logged]:
        channels: dict[int, Channel] = {}
        for record in _until_cut(reader):
            if isinstance(record, Metadata) and record.name == METADATA:
                self.metadata = dict(record.metadata)
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Footer):
                self.complete = True
            elif isinstance(record, Message) and self.metadata:
                yield _logged(record, channels[record.channel_id])
        if not self.metadata:
            raise LogError(f"{self.path}: not the log of a run")


def _until_cut(reader: StreamReader) -> Iterator[McapRecord]:
    """Records up to the end, or to where they stop making sense."""
    records = reader.records
    while True:
        try:
            record = next(records)
        except (StopIteration, McapError, RuntimeError, ValueError, struct.error):
            return  # RuntimeError is what lz4 raises on a damaged chunk
        yield record


def _logged(message: Message, channel: Channel) -> Logged:
    return Logged(
        key=channel.topic.removeprefix("/"),
        payload=message.data,
        encoding=channel.message_encoding,
        logged=message.log_time,
        sequence=message.sequence,
    )
