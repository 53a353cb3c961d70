"""The node's own measurements, and how they read as health."""

from __future__ import annotations

from collections import Counter

from tauten.service.log import LogRecorder
from tauten.service.node.clock import Clock
from tauten.service.node.histogram import Histogram
from tauten.service.wire import Cause, Diagnostic, Level, Mode, Tick, Window

_MS = 1e3


class LoopStatistics:
    """Counts ticks and remembers how long they took.

    Attributes:
        times: histograms of "latency", target to actuation, and "jitter", how late ticks begin.
    """

    def __init__(self) -> None:
        self.times = {"latency": Histogram(), "jitter": Histogram()}
        self._ticks = 0
        self._modes: Counter[str] = Counter()
        self._statuses: Counter[str] = Counter()
        self._clamped = 0
        self._mode = Mode.IDLE
        self._cause = Cause.NO_TARGET
        self._deepest = 0.0
        self._lateness = Window()
        self._latency = Window()
        self._decide = Window()
        self._step = Window()

    def add(self, tick: Tick) -> None:
        """Count a tick."""
        self._ticks += 1
        self._mode, self._cause = tick.mode, tick.cause
        self.times["latency"].add(tick.latency)
        self.times["jitter"].add(tick.lateness)
        self._modes[tick.mode.value] += 1
        self._clamped += tick.clamped
        self._lateness.add(tick.lateness)
        self._latency.add(tick.latency)
        self._deepest = min(self._deepest, tick.deepest_gap)
        if tick.status:
            self._statuses[tick.status] += 1
            self._decide.add(tick.decide)
            self._step.add(tick.step)

    def diagnostics(
        self,
        clock: Clock,
        arrived: list[Diagnostic],
        recorder: LogRecorder | None,
        fixed: dict[str, str],
    ) -> list[Diagnostic]:
        """Health of the node.

        Args:
            clock: of the loop.
            arrived: counts of messages.
            recorder: of the log, if there is one.
            fixed: facts that do not change, such as the factorisation's name.
        """
        found = [self._loop(clock), self._decisions(), *arrived]
        if recorder is not None:
            found.append(_log(recorder))
        return [*found, Diagnostic("system", Level.OK, "", fixed)]

    def _loop(self, clock: Clock) -> Diagnostic:
        missed = clock.missed
        return Diagnostic(
            "loop",
            Level.WARN if missed else Level.OK,
            f"{missed} deadlines missed, {clock.skipped} ticks skipped",
            {
                "period_ms": f"{_MS * clock.period:.4g}",
                "ticks": str(self._ticks),
                "missed": str(missed),
                "skipped": str(clock.skipped),
                **self._lateness.entries("lateness_ms", _MS),
                **self._latency.entries("latency_ms", _MS),
                **self._decide.entries("decide_ms", _MS),
                **self._step.entries("step_ms", _MS),
                **{f"{name}_histogram_ms": times.text() for name, times in self.times.items()},
            },
        )

    def _decisions(self) -> Diagnostic:
        bad = sum(count for name, count in self._statuses.items() if name != "OK")
        values = {"mode": self._mode.value, "cause": self._cause.value}
        values["clamped"] = str(self._clamped)
        values |= {f"ticks_{mode}": str(count) for mode, count in self._modes.items()}
        values |= {f"status_{name}": str(count) for name, count in self._statuses.items()}
        values["deepest_penetration_mm"] = f"{_MS * max(-self._deepest, 0.0):.4g}"
        level = Level.WARN if bad or self._clamped else Level.OK
        doing = f"{self._mode} ({self._cause})" if self._cause else self._mode.value
        return Diagnostic("decisions", level, f"{doing}, {bad} not OK", values)


def _log(recorder: LogRecorder) -> Diagnostic:
    broken = bool(recorder.fault or recorder.dropped)
    message = recorder.fault or f"{recorder.dropped} messages lost"
    level = Level.ERROR if recorder.fault else Level.WARN if broken else Level.OK
    return Diagnostic("log", level, message, {"dropped": str(recorder.dropped)})
