"""Statistics of the loop in fixed memory, for health and for Prometheus."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter, deque
from math import isfinite, isnan

from tauten.controller import Status
from tauten.model import Actuators, EffectorLayout
from tauten.model.numerics import Array
from tauten.service.log import LogRecorder
from tauten.service.node.clock import Clock
from tauten.service.node.limiter import ROUNDING
from tauten.service.node.loop import Action
from tauten.service.wire import Cause, Diagnostic, Level, Mode, Tick, Window

# Prediction errors: ticks that they are averaged over, and the average from which on health warns.
AVERAGED = 50
SURPRISING = 5e-3  # of the robot's size; followed targets have at most a tenth of it
# Upper bounds of the buckets [s]; a last one is for longer times.
BOUNDS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 0.1, 0.2, 0.5)
_MS = 1e3


class Histogram:
    """Counts times by bucket.

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
        """Upper bound [s] and number of values up to it, the form of Prometheus."""
        found, below = [], 0
        for bound, count in zip([*(f"{b:g}" for b in BOUNDS), "+Inf"], self.counts, strict=True):
            below += count
            found.append((bound, float(below)))
        return found


class LoopStatistics:
    """Counts ticks and keeps how long they took.

    Attributes:
        times: histograms of "latency", target to actuation, and "jitter", how late ticks begin.
    """

    def __init__(self, actuators: Actuators, effectors: EffectorLayout, size: float) -> None:
        """Start without ticks.

        Args:
            actuators: of the robot.
            effectors: their kinds, and the units in which errors of their rows are metres.
            size: of the robot [m].
        """
        self.times = {"latency": Histogram(), "jitter": Histogram()}
        self._actuators = actuators
        self._effectors = effectors
        self._size = size
        self._apart = 0.0
        # of the last decisions in a row, whether time ended them
        self._cut: deque[bool] = deque(maxlen=AVERAGED)
        self._ticks = 0
        self._modes: Counter[str] = Counter()
        self._statuses: Counter[str] = Counter()
        self._clamped = 0
        self._unknown: tuple[str, ...] = ()  # what was not finite last
        self._action: Action | None = None
        self._mode = Mode.IDLE
        self._cause = Cause.NO_TARGET
        self._deepest = 0.0
        self._lateness = Window()
        self._latency = Window()
        self._decide = Window()
        self._step = Window()

    def add(self, tick: Tick, action: Action, values: Array) -> None:
        """Count a tick.

        Args:
            tick: as it is published.
            action: that left in it.
            values: (n_v,) goal values that the effectors of the model have after it.
        """
        apart = self._effectors.error(values, action.actuation.effector_values)  # m
        if action.decided and isfinite(apart):
            self._apart += (apart - self._apart) / AVERAGED
        self._ticks += 1
        self._action = action
        self._mode, self._cause = tick.mode, tick.cause
        self.times["latency"].add(tick.latency)
        self.times["jitter"].add(tick.lateness)
        self._modes[tick.mode.value] += 1
        self._clamped += tick.clamped
        if action.wanted.status is Status.NOT_FINITE:
            self._unknown = action.wanted.conflict
        self._lateness.add(tick.lateness)
        self._latency.add(tick.latency)
        self._deepest = min(self._deepest, tick.deepest_gap)
        if tick.status:
            self._cut.append(action.checks >= 0)
            self._statuses[tick.status] += 1
            self._decide.add(tick.decide)
            self._step.add(tick.step)
        else:
            self._cut.clear()

    def diagnostics(
        self,
        clock: Clock,
        arrived: list[Diagnostic],
        recorder: LogRecorder | None,
        fixed: dict[str, str],
    ) -> list[Diagnostic]:
        """Health of the node."""
        found = [self._loop(clock), self._decisions(), self._efforts(), *arrived]
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
        values["deepest_penetration_mm"] = f"{_MS * max(0.0, -self._deepest):.4g}"
        values["prediction_error_mm"] = f"{_MS * self._apart:.3g}"
        surprising = self._apart > SURPRISING * self._size
        cut = sum(self._cut)
        often = 2 * cut > len(self._cut)
        values["cut"] = str(cut)
        warned = bad or self._clamped or self._unknown or surprising or often
        level = Level.WARN if warned else Level.OK
        mode = f"{self._mode} ({self._cause})" if self._cause else self._mode.value
        text = f"{mode}, {bad} not OK"
        if self._unknown:
            text += f"; last not finite: {', '.join(self._unknown)}"
        if surprising:
            text += (
                f"; the model moves {_MS * self._apart:.3g} mm a tick away from what decisions predict: "
                "targets are too fast for it, or it does not come to rest"
            )
        if often:
            text += (
                f"; {cut} of the last {len(self._cut)} decisions ran out of time, so that the robot is late: "
                "lower controller.rate, raise service.decision_share, or give contacts fewer points"
            )
        return Diagnostic("decisions", level, text, values)

    def _efforts(self) -> Diagnostic:
        """Efforts of the last tick that left, and those of the model, which may be beyond the limits."""
        action = self._action
        if action is None:
            return Diagnostic("tensions", Level.OK, "", {})
        left, model = action.actuation.effort.tolist(), action.wanted.needed.tolist()
        values, changed = {}, []
        names, kinds = self._actuators.names, self._actuators.kinds
        for name, kind, sent, wanted in zip(names, kinds, left, model, strict=True):
            unit = kind.effort.unit
            values[f"{name}_{unit.lower()}"] = f"{sent:.4g}"
            values[f"{name}_{unit.lower()}_model"] = f"{wanted:.4g}"
            if abs(wanted - sent) > ROUNDING * max(abs(sent), abs(wanted), 1.0):
                changed.append(
                    f"{name}: {sent:.3g} {unit} have left, the model has {wanted:.3g} {unit}"
                )
        if self._mode is Mode.STOP:  # whatever it had before
            return Diagnostic("tensions", Level.OK, "released without the model", values)
        level = Level.WARN if changed else Level.OK
        return Diagnostic("tensions", level, "; ".join(changed) or "as in the model", values)


def _log(recorder: LogRecorder) -> Diagnostic:
    broken = bool(recorder.fault or recorder.dropped)
    message = recorder.fault or f"{recorder.dropped} messages lost"
    level = Level.ERROR if recorder.fault else Level.WARN if broken else Level.OK
    return Diagnostic("log", level, message, {"dropped": str(recorder.dropped)})
