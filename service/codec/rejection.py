"""Why a message was refused."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

_MOST_QUOTED = 40  # characters of what was received, in a reason


class RejectionReason(Enum):
    """Why a message was refused; the value is its name in counters."""

    TOO_LARGE = "too_large"
    ENCODING = "unknown_encoding"
    WRONG_TYPE = "wrong_type"
    MALFORMED = "malformed"
    WRONG_FRAME = "wrong_frame"
    WRONG_SHAPE = "wrong_shape"
    NOT_FINITE = "not_finite"
    NO_ROTATION = "no_rotation"
    OUT_OF_REACH = "out_of_reach"
    TOO_OLD = "too_old"
    NOT_PLAUSIBLE = "not_plausible"
    UNKNOWN = "unknown_command"
    NOT_NOW = "not_possible_now"
    LOCK_REFUSED = "lock_refused"


@dataclass(frozen=True, slots=True)
class Rejection:
    """A message that was refused: the reason, and a sentence with what was found and what is allowed."""

    reason: RejectionReason
    detail: str


def quoted(received: object) -> str:
    """What was received, for a reason: in quotation marks, at most 40 characters, all of them printable.

    Whoever sends a message chooses this text, and logs, terminals and the viewer show it.
    """
    text = received if isinstance(received, str) else str(received)
    shown = "".join(
        c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text[:_MOST_QUOTED]
    )
    return f"'{shown}'" if len(text) <= _MOST_QUOTED else f"'{shown}'…"
