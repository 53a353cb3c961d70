"""Time that a decision may take, and how a decision that was cut by it is repeated."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter


class TimeLimit:
    """A limit of time that is checked where a search may end early.

    What a search finds depends on the clock only through the number of checks that passed. Logs keep that
    number of a decision that was cut, and a limit made of it cuts the decision there again.

    Attributes:
        passed: checks that found time left, until one did not.
        cut: whether one did not; none finds time left after it.
    """

    def __init__(
        self,
        seconds: float = math.inf,
        clock: Callable[[], float] = perf_counter,
        checks: int | None = None,
    ) -> None:
        """Start the time.

        Args:
            seconds: from now on.
            clock: tells the time [s].
            checks: number of checks to pass, instead of a time.

        Raises:
            ValueError: a negative time, or one that is not a number.
        """
        if not seconds >= 0.0:
            raise ValueError(f"time is {seconds} s, expected 0 or more")
        self._end = seconds if seconds == math.inf else clock() + seconds
        self._checks = checks
        self.clock = clock
        self.passed = 0
        self.cut = False

    @property
    def limited(self) -> bool:
        """Whether any check may fail."""
        return self._checks is not None or self._end < math.inf

    def allows(self, seconds: float = 0.0) -> bool:
        """Whether there is time left for what takes so long [s]."""
        if self.cut:
            return False
        if self._checks is not None:
            self.cut = self.passed >= self._checks
        elif self._end < math.inf:
            self.cut = not self.clock() + seconds < self._end
        self.passed += not self.cut
        return not self.cut

    @property
    def repeats(self) -> int:
        """Number of checks that repeats the decision: those that passed, −1 where it was not cut."""
        return self.passed if self.cut else -1
