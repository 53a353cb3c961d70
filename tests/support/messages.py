"""Messages as tests read them, and effectors as a description has them."""

from __future__ import annotations

from tauten.model.schema import COMPONENTS, EffectorKind
from tauten.service.wire import DescribedEffector, Point, Rejection, decode_effector


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


def effector(
    name: str, kind: EffectorKind, *rest: float, weight: tuple[float, ...] | None = None
) -> DescribedEffector:
    """An effector with goal values at rest; all of its components count where no weight is given."""
    ones = (1.0,) * COMPONENTS[kind]
    return DescribedEffector(name=name, kind=kind, rest=rest, weight=weight or ones, exact=False)
