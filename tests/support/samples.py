"""What arrives for a node, without a network: samples in rings, by their keys."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from tauten.service.wire import CDR


@dataclass(frozen=True)
class Sample:
    """A message as Zenoh gives it."""

    payload: bytes
    encoding: str = CDR
    timestamp: None = None


@dataclass
class Ring:
    """Samples of one key."""

    samples: deque[Sample] = field(default_factory=deque)

    def try_recv(self) -> Sample | None:
        return self.samples.popleft() if self.samples else None


@dataclass
class Session:
    """Samples by their keys."""

    samples: dict[str, deque[Sample]] = field(default_factory=dict)

    def declare_subscriber(self, key: str, _: object) -> Ring:
        return Ring(self.samples.setdefault(str(key), deque()))
