"""The log of a run: an MCAP file that Foxglove opens, written by a thread beside the loop.

The loop appends bytes to a queue, without a lock and without a notification: the thread reads the queue
twenty times a second. Chunks are small and flushed as soon as they are full, so that a crash loses
only the last moment; a full disk stops the log, never the loop.
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from dataclasses import dataclass
from io import BufferedWriter
from pathlib import Path

from mcap.writer import CompressionType, Writer

from tauten.service.process import locked_new
from tauten.service.wire import definition

log = logging.getLogger(__name__)

METADATA = "tauten"
_CHUNK = 32_768  # bytes, less than a second at 50 Hz; MCAP keeps 2 kB for each until the end
_WAITING = 10_000  # messages in the queue at most
_PAUSE = 0.05  # s between two reads of the queue


@dataclass(frozen=True, slots=True)
class Entry:
    """A message for the log.

    Attributes:
        key: Zenoh key.
        kind: message type.
        payload: the message in CDR.
        logged: when it was seen [ns since the epoch].
        published: when it was made [ns since the epoch].
        sequence: tick it belongs to.
    """

    key: str
    kind: str
    payload: bytes
    logged: int
    published: int
    sequence: int


class LogRecorder:
    """Writes a log.

    Attributes:
        dropped: messages lost because the disk was too slow or full.
        fault: why writing stopped, "" while it goes on.
    """

    def __init__(self, path: Path, metadata: dict[str, str]) -> None:
        """Create the file and its folder; facts about the run are written first.

        Raises:
            OSError: the file cannot be created, or another process records to it.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        self.dropped = 0
        self.fault = ""
        self._file: BufferedWriter = open(path, "wb", opener=locked_new)  # noqa: SIM115 (a thread closes it)
        self._writer = Writer(
            self._file,
            chunk_size=_CHUNK,
            compression=CompressionType.LZ4,
            enable_data_crcs=True,  # covers the metadata, which stand outside the chunks
        )
        try:
            self._writer.start(profile="ros2", library="tauten")
            self._writer.add_metadata(METADATA, metadata)
            self._file.flush()
        except OSError as error:
            self._file.raw.close()  # without writing what cannot be written
            if path.is_file():
                path.unlink()
            raise OSError(error.errno, error.strerror, str(path)) from error
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._waiting: deque[Entry] = deque()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="recorder")
        self._thread.start()

    def write(self, entry: Entry) -> None:
        """Queue a message; never waits."""
        if self.fault or len(self._waiting) >= _WAITING:
            self.dropped += 1
        else:
            self._waiting.append(entry)

    def close(self) -> None:
        """Write what is left and finish the file."""
        self._closing.set()
        self._thread.join()

    def _run(self) -> None:
        try:
            while not self._closing.wait(_PAUSE):
                self._write_waiting()
            self._write_waiting()
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._file.close()
        except OSError as error:
            self.fault = f"recording stopped: {self._file.name}: {error.strerror}"
            log.error(self.fault)
            self._file.raw.close()
            self.dropped += len(self._waiting)
            self._waiting.clear()

    def _write_waiting(self) -> None:
        if not self._waiting:
            return
        while self._waiting:
            self._add(self._waiting.popleft())
        self._file.flush()

    def _add(self, entry: Entry) -> None:
        self._writer.add_message(
            channel_id=self._channel(entry),
            log_time=entry.logged,
            publish_time=entry.published,
            sequence=entry.sequence % 2**32,
            data=entry.payload,
        )

    def _channel(self, entry: Entry) -> int:
        if entry.key not in self._channels:
            self._channels[entry.key] = self._writer.register_channel(
                topic=f"/{entry.key}",
                message_encoding="cdr",  # alone, as the profile ros2 of MCAP has it
                schema_id=self._schema(entry.kind),
            )
        return self._channels[entry.key]

    def _schema(self, kind: str) -> int:
        if kind not in self._schemas:
            self._schemas[kind] = self._writer.register_schema(
                name=kind, encoding="ros2msg", data=definition(kind).encode()
            )
        return self._schemas[kind]
