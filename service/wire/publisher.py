"""A declared publisher of one key, with the encoding that names the ROS 2 type."""

from __future__ import annotations

import zenoh

from tauten.service.codec import CDR


class Publisher:
    """Publishes messages of one type on one key.

    Attributes:
        key: Zenoh key.
        kind: message type.
    """

    def __init__(self, session: zenoh.Session, key: str, kind: str, urgent: bool = True) -> None:
        """Declare the publisher; urgent messages are sent ahead of others, and never in a batch."""
        self.key = key
        self.kind = kind
        priority = zenoh.Priority.INTERACTIVE_HIGH if urgent else zenoh.Priority.DATA_LOW
        self._publisher = session.declare_publisher(
            key,
            encoding=f"{CDR};{kind}",
            # a slow subscriber must never block the loop
            congestion_control=zenoh.CongestionControl.DROP,
            priority=priority,
            express=urgent,
        )

    @property
    def has_subscribers(self) -> bool:
        """Whether there is a subscriber to the key, as this session has found by discovery."""
        status = self._publisher.matching_status
        return bool(getattr(status, "matching", status))  # zenoh's type hints take it for a bool

    def put(self, payload: bytes) -> None:
        """Publish."""
        self._publisher.put(payload)
