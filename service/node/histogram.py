"""Histograms of times in fixed memory, for health and for Prometheus."""

from __future__ import annotations

from bisect import bisect_left
from math import isnan

# Upper bounds of the buckets [s]; a last one takes what is longer.
BOUNDS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 0.1, 0.2, 0.5)


class Histogram:
    """Counts values by bucket.

    Attributes:
        counts: values in each bucket, the last for those beyond all bounds.
        total: sum of the values [s].
    """

    def __init__(self) -> None:
        self.counts = [0] * (len(BOUNDS) + 1)
        self.total = 0.0

    def add(self, value: float) -> None:
        """Count a value [s]; NaN is left out."""
        if not isnan(value):
            self.counts[bisect_left(BOUNDS, value)] += 1
            self.total += value

    def text(self) -> str:
        """Upper bound in ms and count of each bucket that is not empty, such as "0.5:12 1:3 more:1"."""
        names = [*(f"{1e3 * bound:g}" for bound in BOUNDS), "more"]
        pairs = zip(names, self.counts, strict=True)
        return " ".join(f"{name}:{count}" for name, count in pairs if count)

    def cumulative(self) -> list[tuple[str, float]]:
        """Upper bound [s] and number of values up to it, as Prometheus has it."""
        found, below = [], 0
        for bound, count in zip([*(f"{b:g}" for b in BOUNDS), "+Inf"], self.counts, strict=True):
            below += count
            found.append((bound, float(below)))
        return found
