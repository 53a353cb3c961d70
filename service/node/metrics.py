"""The node's health as metrics in Prometheus text.

`tauten metrics` requests it over Zenoh, and serves it over HTTP for Prometheus to scrape.
"""

from __future__ import annotations

import re
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator

from prometheus_client import generate_latest
from prometheus_client.core import (
    GaugeMetricFamily,
    HistogramMetricFamily,
    InfoMetricFamily,
    Metric,
)
from prometheus_client.registry import Collector, CollectorRegistry

from tauten.service.node.statistics import Histogram
from tauten.service.wire import Diagnostic


class _Collected(Collector):
    """The metrics of one moment, in the form that prometheus_client needs."""

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
        numbers = dict[tuple[str, ...], float]()
        for item in self._diagnostics:
            level.add_metric((self._robot, item.name), float(item.level))
            texts = dict[tuple[str, ...], str]()
            for key, value in item.values.items():
                number = _number(value)
                if number is None:
                    texts[(key,)] = value
                else:
                    numbers[item.name, key] = number
            if texts:
                info = InfoMetricFamily(f"tauten_{_name(item.name)}", item.name, labels=label)
                info.add_metric(robot, {name: texts[key] for key, name in _apart(texts).items()})
                yield info
        for words, name in _apart(numbers).items():
            gauge = GaugeMetricFamily(f"tauten_{name}", ": ".join(words), labels=label)
            gauge.add_metric(robot, numbers[words])
            yield gauge
        yield level
        for key, times in self._times.items():
            name = f"tauten_{key}_seconds"
            family = HistogramMetricFamily(name, f"{key} of a tick", labels=label)
            family.add_metric(robot, times.cumulative(), times.total)
            yield family


def prometheus_text(
    robot: str, diagnostics: list[Diagnostic], times: dict[str, Histogram]
) -> bytes:
    """All numbers and facts of the node's health, and its histograms, in the text format of Prometheus."""
    registry = CollectorRegistry(auto_describe=False)
    registry.register(_Collected(robot, diagnostics, times))
    return generate_latest(registry)


def _name(text: str) -> str:
    return re.sub(r"\W", "_", text.lower())


def _apart(texts: Iterable[tuple[str, ...]]) -> dict[tuple[str, ...], str]:
    """A name for each tuple of texts; those with the same one end with a checksum of their texts."""
    names = {words: "_".join(map(_name, words)) for words in texts}
    count = Counter(names.values())
    return {
        words: name if count[name] == 1 else f"{name}_{zlib.crc32(repr(words).encode()):08x}"
        for words, name in names.items()
    }


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
