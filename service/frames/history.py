"""Frames that can be looked at again, in bounded memory."""

from __future__ import annotations

from bisect import bisect_right

from tauten.service.frames.frame import ViewFrame

BUDGET = 256 * 2**20  # bytes


class FrameHistory:
    """Frames in the order of their time.

    When they need more memory than allowed, either the oldest ones are forgotten, or every second one:
    then the whole run remains, at a lower rate.
    """

    def __init__(self, whole: bool, budget: int = BUDGET) -> None:
        self._whole = whole
        self._budget = budget
        self._frames: list[ViewFrame] = []
        self._times: list[float] = []
        self._bytes = 0
        self._stride = 1
        self._count = 0

    def __len__(self) -> int:
        return len(self._frames)

    @property
    def first(self) -> float:
        """Time of the first frame [s]."""
        return self._times[0] if self._times else 0.0

    @property
    def last(self) -> float:
        """Time of the last frame [s]."""
        return self._times[-1] if self._times else 0.0

    def add(self, frame: ViewFrame) -> None:
        """Add a frame later than all others."""
        self._count += 1
        if (self._count - 1) % self._stride:
            return
        self._frames.append(frame)
        self._times.append(frame.time)
        self._bytes += frame.nbytes
        while self._bytes > self._budget and len(self._frames) > 1:
            self._thin() if self._whole else self._forget()

    def at(self, time: float) -> ViewFrame | None:
        """The last frame that is not later than a time [s]; the first one before it, None without any."""
        if not self._frames:
            return None
        return self._frames[max(bisect_right(self._times, time) - 1, 0)]

    def between(self, first: float, last: float) -> list[ViewFrame]:
        """Frames within a span of time [s]."""
        begin, end = bisect_right(self._times, first), bisect_right(self._times, last)
        return self._frames[begin:end]

    def _forget(self) -> None:
        """Forget the oldest tenth."""
        count = max(len(self._frames) // 10, 1)
        self._bytes -= sum(frame.nbytes for frame in self._frames[:count])
        del self._frames[:count], self._times[:count]

    def _thin(self) -> None:
        """Forget every second frame."""
        self._frames, self._times = self._frames[::2], self._times[::2]
        self._bytes = sum(frame.nbytes for frame in self._frames)
        self._stride *= 2
