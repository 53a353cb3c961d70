"""Messages as tests read them."""

from __future__ import annotations

from tauten.service.wire import Point, Rejection, decode_effector


def decode_point(payload: bytes, encoding: str) -> Point | Rejection:
    """A point from CDR or JSON, as a node reads the target of an effector that is a point.

    Args:
        payload: the message.
        encoding: names the format and the type.
    """
    found = decode_effector("point", "tip", payload, encoding)
    if isinstance(found, Rejection):
        return found
    x, y, z = found.values
    return Point(found.stamp, found.frame, (x, y, z))
