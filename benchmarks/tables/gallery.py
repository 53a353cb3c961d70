"""The robots of the gallery, and the errors of reduced models, as tables."""

from __future__ import annotations

from benchmarks.steps import GalleryBench, LoadBench
from tauten.service.replay import Spread
from tauten.service.tables import Numbers, Page, measured_on


def gallery_page(result: GalleryBench) -> Page:
    """Its table."""
    about = f"Inverse steps, median / 99th percentile. {measured_on(result.machine)}"
    return Page("python -m benchmarks gallery", about, (gallery_table(result),))


def load_errors_page(result: LoadBench) -> Page:
    """Its table; it has no times."""
    about = "Equilibria, and steps of a swing, of reduced against full model."
    return Page("python -m benchmarks load-errors", about, (loads_table(result),))


def gallery_table(result: GalleryBench) -> Numbers:
    """Sizes, times of inverse steps, and errors at equilibria held out."""
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


def loads_table(result: LoadBench) -> Numbers:
    """Errors of the reduced models under loads and in motions that took no part in the training."""
    head = (
        "robot", "loads", "modes", "elements", "cases", "lost", "mean / max [mm]", "largest [% of its size]",
        "largest at",
    )  # fmt: skip
    rows = []
    for row in result.robots:
        for load in row.loads:
            known = load.mean_mm is not None and load.max_mm is not None
            rows.append(
                (
                    row.robot, load.kind, str(row.state_modes), str(row.sampled), str(load.cases),
                    str(load.lost),
                    f"{load.mean_mm:.2f} / {load.max_mm:.2f}" if known else "–",
                    f"{100 * load.max_mm / row.size_mm:.2f}" if known else "–",  # type: ignore[operator]
                    load.at,
                )
            )  # fmt: skip
    return Numbers("", head, tuple(rows), 2)


def _spread(value: Spread | None) -> str:
    """Median and 99th percentile."""
    return "–" if value is None else f"{value.p50:.2f} / {value.p99:.2f}"
