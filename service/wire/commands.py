"""Commands of an operator: one sentence of words in each message, in CDR or JSON.

`enable`, `hold`, `stop`, `reset`, `let-go`, `lock ACTUATOR position VALUE`, `lock ACTUATOR force VALUE`,
`unlock ACTUATOR`, with values in SI units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from tauten.service.codec import (
    JSON,
    TEXT,
    MessageCounts,
    Rejection,
    RejectionReason,
    from_cdr,
    from_json,
    payload_format,
    quoted,
)
from tauten.service.link import LockOrder, OperatorCommand, OperatorOrder
from tauten.service.wire.effector_subscriber import Ring, payload_of, waiting

COMMAND_RING = 128  # that are read in a tick; older ones are dropped unread, a stop as well
_LONGEST_NAME = 100  # characters of an actuator's


@dataclass(frozen=True, slots=True)
class ReceivedCommand:
    """A command that was decoded.

    Attributes:
        command: of the operator.
        payload: the message as it came.
        encoding: names its format.
    """

    command: OperatorOrder
    payload: bytes
    encoding: str


class CommandSubscriber:
    """Collects commands.

    Attributes:
        counts: messages, accepted and refused by reason; a command is accepted when it has been carried out.
    """

    def __init__(self, source: Ring) -> None:
        self.counts = MessageCounts()
        self._source = source

    def read(self) -> list[ReceivedCommand]:
        """Commands that have arrived, oldest first."""
        found = []
        for sample in waiting(self._source, COMMAND_RING):
            payload, encoding = payload_of(sample), str(sample.encoding)
            if isinstance(payload, Rejection):
                self.counts.refuse(payload)
                continue
            command = decode_command(payload, encoding)
            if isinstance(command, Rejection):
                self.counts.refuse(command)
            else:
                found.append(ReceivedCommand(command, payload, encoding))
        return found


def decode_command(payload: bytes, encoding: str) -> OperatorOrder | Rejection:
    """A command from CDR or JSON, whichever the encoding names."""
    found = payload_format(payload, encoding, TEXT)
    if isinstance(found, Rejection):
        return found
    read = from_json if found == JSON else from_cdr
    message: Any = read(TEXT, payload)
    if isinstance(message, Rejection):
        return message
    text = str(message.data)
    if text in set(OperatorCommand):
        return OperatorCommand(text)
    words = text.split(" ")
    if len(words) > 1 and len(words[1]) > _LONGEST_NAME:
        detail = f"found a name of {len(words[1])} characters in {quoted(text)}, allowed are {_LONGEST_NAME}"
        return Rejection(RejectionReason.UNKNOWN, detail)
    if len(words) == 2 and words[0] == "unlock":
        return LockOrder(words[1])
    if len(words) == 4 and words[0] == "lock" and words[2] in ("position", "force"):
        return _lock_order(words[1], words[2], words[3])
    allowed = ", ".join((*OperatorCommand, "lock ACTUATOR position|force VALUE", "unlock ACTUATOR"))
    return Rejection(
        RejectionReason.UNKNOWN, f"found command {quoted(text)}, allowed are {allowed}"
    )


def _lock_order(actuator: str, quantity: str, number: str) -> LockOrder | Rejection:
    try:
        value = float(number)
    except ValueError:
        return Rejection(RejectionReason.MALFORMED, f"{quoted(number)} is not a number")
    if not math.isfinite(value):
        return Rejection(RejectionReason.NOT_FINITE, f"{quantity} {value} is not finite")
    if quantity == "position":
        return LockOrder(actuator, position=value)
    return LockOrder(actuator, force=value)
