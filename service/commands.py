"""Commands of an operator: one word a message, in CDR or JSON."""

from __future__ import annotations

import json

from tauten.service.health import Tally
from tauten.service.inbox import Source, payload_of
from tauten.service.messages import (
    JSON,
    TEXT,
    Fault,
    Reason,
    from_cdr,
    new,
    payload_format,
    to_cdr,
)
from tauten.service.state_machine import Command

RING = 16


class Commands:
    """Collects commands.

    Attributes:
        tally: counts by what became of them.
    """

    def __init__(self, source: Source) -> None:
        self.tally = Tally()
        self._source = source

    def drain(self) -> list[tuple[Command, bytes, bool]]:
        """Take what has arrived, oldest first: the command, its message as it came, and whether as JSON."""
        found = []
        for _ in range(RING):
            sample = self._source.try_recv()
            if sample is None:
                break
            payload, encoding = payload_of(sample), str(sample.encoding)
            command = payload if isinstance(payload, Fault) else decode_command(payload, encoding)
            if isinstance(command, Fault):
                self.tally.refuse(command)
            elif not isinstance(payload, Fault):
                found.append((command, payload, encoding.startswith(JSON)))
        return found


def encode_command(command: Command) -> bytes:
    """A command in CDR."""
    return to_cdr(TEXT, new(TEXT, data=command.value))


def decode_command(payload: bytes, encoding: str) -> Command | Fault:
    """A command from CDR or JSON, whichever the encoding names."""
    found = payload_format(payload, encoding, TEXT)
    if isinstance(found, Fault):
        return found
    text = _json_text(payload) if found == JSON else _cdr_text(payload)
    if isinstance(text, Fault):
        return text
    if text not in set(Command):
        allowed = ", ".join(Command)
        return Fault(Reason.UNKNOWN, f"found command {text[:20]!r}, allowed are {allowed}")
    return Command(text)


def _cdr_text(payload: bytes) -> str | Fault:
    message = from_cdr(TEXT, payload)
    return message if isinstance(message, Fault) else str(message.data)


def _json_text(payload: bytes) -> str | Fault:
    try:
        return str(json.loads(payload)["data"])
    except (ValueError, TypeError, KeyError, IndexError, RecursionError) as error:
        return Fault(Reason.MALFORMED, f"not a {TEXT} as JSON: {type(error).__name__} {error}")
