"""NodeOutputs: one declared publisher a key, with the encoding that names the ROS 2 type."""

from __future__ import annotations

import zenoh

from tauten.service.wire.messages import CDR


class Publisher:
    """A key that messages of one type leave on.

    Attributes:
        key: where.
        kind: message type.
    """

    def __init__(self, session: zenoh.Session, key: str, kind: str, urgent: bool = True) -> None:
        """Declare the publisher.

        Args:
            session: open Zenoh session.
            key: where to publish.
            kind: message type.
            urgent: ahead of other messages, and never batched.
        """
        self.key = key
        self.kind = kind
        priority = zenoh.Priority.INTERACTIVE_HIGH if urgent else zenoh.Priority.DATA_LOW
        self._publisher = session.declare_publisher(
            key,
            encoding=f"{CDR};{kind}",
            # a slow reader must never hold the loop up
            congestion_control=zenoh.CongestionControl.DROP,
            priority=priority,
            express=urgent,
        )

    @property
    def heard(self) -> bool:
        """Whether anybody subscribes to the key, as far as this session knows."""
        status = self._publisher.matching_status
        return bool(getattr(status, "matching", status))  # zenoh's type hints take it for a bool

    def put(self, payload: bytes) -> None:
        """Publish."""
        self._publisher.put(payload)
