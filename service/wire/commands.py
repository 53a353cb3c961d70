"""Commands of an operator: one word a message, in CDR or JSON."""

from __future__ import annotations

import json

from tauten.service.wire.health import MessageCounts
from tauten.service.wire.messages import (
    JSON,
    TEXT,
    Rejection,
    RejectionReason,
    from_cdr,
    new,
    payload_format,
    to_cdr,
)
from tauten.service.wire.modes import OperatorCommand
from tauten.service.wire.position_subscriber import Source, payload_of

COMMAND_RING = 16


class Commands:
    """Collects commands.

    Attributes:
        tally: counts by what became of them.
    """

    def __init__(self, source: Source) -> None:
        self.tally = MessageCounts()
        self._source = source

    def drain(self) -> list[tuple[OperatorCommand, bytes, bool]]:
        """Take what has arrived, oldest first: the command, its message as it came, and whether as JSON."""
        found = []
        for _ in range(COMMAND_RING):
            sample = self._source.try_recv()
            if sample is None:
                break
            payload, encoding = payload_of(sample), str(sample.encoding)
            command = (
                payload if isinstance(payload, Rejection) else decode_command(payload, encoding)
            )
            if isinstance(command, Rejection):
                self.tally.refuse(command)
            elif not isinstance(payload, Rejection):
                found.append((command, payload, encoding.startswith(JSON)))
        return found


def encode_command(command: OperatorCommand) -> bytes:
    """A command in CDR."""
    return to_cdr(TEXT, new(TEXT, data=command.value))


def decode_command(payload: bytes, encoding: str) -> OperatorCommand | Rejection:
    """A command from CDR or JSON, whichever the encoding names."""
    found = payload_format(payload, encoding, TEXT)
    if isinstance(found, Rejection):
        return found
    text = _json_text(payload) if found == JSON else _cdr_text(payload)
    if isinstance(text, Rejection):
        return text
    if text not in set(OperatorCommand):
        allowed = ", ".join(OperatorCommand)
        return Rejection(
            RejectionReason.UNKNOWN, f"found command {text[:20]!r}, allowed are {allowed}"
        )
    return OperatorCommand(text)


def _cdr_text(payload: bytes) -> str | Rejection:
    message = from_cdr(TEXT, payload)
    return message if isinstance(message, Rejection) else str(message.data)


def _json_text(payload: bytes) -> str | Rejection:
    try:
        return str(json.loads(payload)["data"])
    except (ValueError, TypeError, KeyError, IndexError, RecursionError) as error:
        return Rejection(
            RejectionReason.MALFORMED, f"not a {TEXT} as JSON: {type(error).__name__} {error}"
        )
