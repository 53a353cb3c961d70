"""The robots of the gallery as a table."""

from __future__ import annotations

from tauten.service.bench import GalleryBench
from tauten.service.replay import Spread
from tauten.service.tables.numbers import Numbers


def gallery_table(result: GalleryBench) -> Numbers:
    """Sizes, times of inverse steps and errors."""
    head = (
        "robot", "nodes", "actuators", "candidates", "k", "r", "full step [ms]", "reduced step [ms]",
        "tip, mean / max [mm]", "of its size [%]", "campaign",
    )  # fmt: skip
    rows = []
    for row in result.robots:
        mean, most = row.tip_mean_mm, row.tip_max_mm
        known = mean is not None and most is not None
        rows.append(
            (
                row.robot, str(row.nodes), str(row.actuators), str(row.candidates),
                str(row.modes) if row.modes else "–",
                "–" if row.state_modes is None else str(row.state_modes),
                _spread(row.full_ms), _spread(row.reduced_ms),
                f"{mean:.3f} / {most:.3f}" if known else "–",
                f"{100 * mean / row.size_mm:.2f} / {100 * most / row.size_mm:.2f}"  # type: ignore[operator]
                if known else "–",
                f"{row.campaign_equilibria} equilibria, {row.campaign_s / 60.0:.1f} min",
            )
        )  # fmt: skip
    return Numbers("", head, tuple(rows))


def _spread(value: Spread | None) -> str:
    """Median and 99th percentile."""
    return "–" if value is None else f"{value.p50:.2f} / {value.p99:.2f}"
