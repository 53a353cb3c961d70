"""Metrics: the node's health as Prometheus text, answered on a key to whoever asks.

The loop itself answers, in the time left after a tick, so that no other thread runs Python code beside
it. `tauten metrics` asks, and serves the answer over HTTP for Prometheus to scrape.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

import zenoh
from prometheus_client import generate_latest
from prometheus_client.core import (
    GaugeMetricFamily,
    HistogramMetricFamily,
    InfoMetricFamily,
    Metric,
)
from prometheus_client.registry import Collector, CollectorRegistry

from tauten.service.node.histogram import Histogram
from tauten.service.wire import Diagnostic, Keys

_WAITING = 4  # questions; more are answered by nobody
_ENCODING = "text/plain"


class MetricsAnswer:
    """Answers questions about a node's metrics."""

    def __init__(self, session: zenoh.Session, robot: str) -> None:
        """Declare the queryable."""
        self._robot = robot
        self._key = Keys(robot).metrics
        self._questions = session.declare_queryable(self._key, zenoh.handlers.FifoChannel(_WAITING))

    def reply(
        self, diagnostics: Callable[[], list[Diagnostic]], times: dict[str, Histogram]
    ) -> None:
        """Answer what has been asked since the last call; costs nothing when nothing was."""
        for _ in range(_WAITING):
            query = self._questions.try_recv()
            if query is None:
                return
            with query:
                text = prometheus_text(self._robot, diagnostics(), times)
                query.reply(self._key, text, encoding=_ENCODING)


class _Collected(Collector):
    """One look at a node, in the form prometheus_client asks for."""

    def __init__(
        self, robot: str, diagnostics: list[Diagnostic], times: dict[str, Histogram]
    ) -> None:
        self._robot = robot
        self._diagnostics = diagnostics
        self._times = times

    def collect(self) -> Iterator[Metric]:
        """Numbers as gauges, texts as labels, histograms."""
        label, robot = ("robot",), (self._robot,)
        level = GaugeMetricFamily(
            "tauten_level", "0 OK, 1 warning, 2 error", labels=("robot", "of")
        )
        for item in self._diagnostics:
            level.add_metric((self._robot, item.name), float(item.level))
            texts = {}
            for key, value in item.values.items():
                number = _number(value)
                if number is None:
                    texts[_name(key)] = value
                    continue
                name = f"tauten_{_name(item.name)}_{_name(key)}"
                gauge = GaugeMetricFamily(name, f"{item.name}: {key}", labels=label)
                gauge.add_metric(robot, number)
                yield gauge
            if texts:
                info = InfoMetricFamily(f"tauten_{_name(item.name)}", item.name, labels=label)
                info.add_metric(robot, texts)
                yield info
        yield level
        for key, times in self._times.items():
            name = f"tauten_{key}_seconds"
            family = HistogramMetricFamily(name, f"{key} of a tick", labels=label)
            family.add_metric(robot, times.cumulative(), times.total)
            yield family


def prometheus_text(
    robot: str, diagnostics: list[Diagnostic], times: dict[str, Histogram]
) -> bytes:
    """Prometheus's text format: all numbers and facts of the node's health, and its histograms."""
    registry = CollectorRegistry(auto_describe=False)
    registry.register(_Collected(robot, diagnostics, times))
    return generate_latest(registry)


def _name(text: str) -> str:
    return re.sub(r"\W", "_", text.lower())


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
