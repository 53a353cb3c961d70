"""What callbacks, threads and other processes have left for a loop."""

from __future__ import annotations

from collections.abc import Iterator
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from multiprocessing.queues import Queue

Item = TypeVar("Item")


def drained(queue: SimpleQueue[Item] | Queue[Item]) -> Iterator[Item]:
    """All items that a queue has now and gets meanwhile, oldest first; it does not wait for any."""
    while True:
        try:
            item = queue.get_nowait()
        except Empty:
            return
        yield item
