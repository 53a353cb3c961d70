"""A periodic clock on absolute deadlines: late beats are counted, lost periods skipped."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from tauten.service.process import has_realtime_priority

_AHEAD = 1.2e-3  # s
_SOON = 1.5e-4  # s, where a period has less to spare; reading a target takes half of it


@dataclass(frozen=True, slots=True)
class Beat:
    """One beat of the clock.

    Attributes:
        index: periods since the start, skipped ones included.
        lateness: seconds between the scheduled time of this beat and its real one, less than a period.
        slack: seconds that were left of the period after its work and the work done ahead of the next beat;
            negative: a deadline was missed by that much.
        skipped: periods lost before this beat.
    """

    index: int
    lateness: float
    slack: float
    skipped: int


class Clock:
    """Beats on a fixed grid of time.

    `wait` returns at the next point of the grid. Work that overruns its period makes the next
    beat late; where whole periods are lost they are skipped, so that the grid does not move and
    nothing queues up.

    Attributes:
        period: seconds between beats.
        missed: beats that came, or whose work was done, after the next one was due.
        skipped: periods lost.
    """

    def __init__(
        self,
        period: float,
        now: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
        awake: bool = False,
    ) -> None:
        """Start the grid now.

        Args:
            period: seconds between beats.
            now: monotonic time [s]; replaced in tests.
            sleep: waits for some seconds; replaced in tests.
            awake: whether the last 1.2 ms before a beat are spent reading the time instead of sleeping.
        """
        self.period = period
        self.missed = 0
        self.skipped = 0
        self._now = now
        self._sleep = sleep
        self._awake = awake
        self._start = now()
        self._index = 0

    @property
    def remaining(self) -> float:
        """Seconds until the next beat is due; negative when it is overdue."""
        return self._start + (self._index + 1) * self.period - self._now()

    def delay(self, seconds: float) -> None:
        """Move the grid by some seconds: the next beat is due a period after one that waited for them."""
        self._start += seconds

    def wait(
        self, before: Callable[[], None] | None = None, idle: Callable[[], None] | None = None
    ) -> Beat:
        """Sleep until the next beat.

        Args:
            before: work of the period that ends, done 1.2 ms before the beat; by a clock that is awake
                0.15 ms before where there is less time; not at all where there is none.
            idle: done after `before` where there are 1.2 ms; not counted as work.
        """
        slack = self.remaining
        if before is not None and slack > _AHEAD:
            self._sleep(slack - _AHEAD)
            slack -= self._timed(before)
            if idle is not None:
                idle()
        elif before is not None and self._awake and slack > _SOON:
            self._watch(_SOON)
            slack -= self._timed(before)
        if (left := self.remaining - (_AHEAD if self._awake else 0.0)) > 0.0:
            self._sleep(left)
        if self._awake:
            self._watch(0.0)
        overdue = max(-self.remaining, 0.0)
        skipped = int(overdue / self.period)
        if skipped > 0:  # by work, or by a thread that was not woken up
            slack = min(slack, -skipped * self.period)
        self.missed += slack < 0.0
        self.skipped += skipped
        self._index += 1 + skipped
        return Beat(self._index, overdue - skipped * self.period, slack, skipped)

    def _watch(self, left: float) -> None:
        """Read the time until only some seconds are left."""
        while self.remaining > left:
            pass

    def _timed(self, work: Callable[[], None]) -> float:
        """Seconds that some work takes."""
        begin = self._now()
        work()
        return self._now() - begin


def punctual_clock(period: float) -> Clock:
    """A clock whose beats are not late by the time it takes to wake a thread up.

    It does not sleep for the last 1.2 ms: a processor that sleeps wakes up late, and is slow until its caches
    are full again. Under a real-time priority it does: there threads wake up soon, and Linux stops one that
    takes more than 95 % of a second.
    """
    return Clock(period, awake=not has_realtime_priority())
