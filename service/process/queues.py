"""What callbacks, threads and other processes have left for a loop."""

from __future__ import annotations

from collections.abc import Iterator
from queue import Empty
from typing import Protocol, TypeVar

Item = TypeVar("Item", covariant=True)


class WaitingItems(Protocol[Item]):
    """A queue that can be asked without waiting."""

    def get_nowait(self) -> Item:
        """The oldest item.

        Raises:
            queue.Empty: there is none.
        """


def drained(queue: WaitingItems[Item]) -> Iterator[Item]:
    """All items that a queue has now and gets meanwhile, oldest first; it does not wait for any."""
    while True:
        try:
            item = queue.get_nowait()
        except Empty:
            return
        yield item
