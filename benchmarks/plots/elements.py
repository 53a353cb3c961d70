"""Figure of the errors of elements over the nodes of a mesh and over the time of a step."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from benchmarks.elements import ElementBench, ElementCase
from tauten.service.plots import COLOURS, EXACT, QUANTITIES, save_figure

STYLES = ("-", "--", ":", "-.")
MARKERS = ("o", "s", "^", "v", "D", "P", "X")


def draw_elements(result: ElementBench, path: str | Path) -> None:
    """Draw the errors of tension, effectors and contact force at the largest pull, a line for each material.

    Args:
        result: the errors and times.
        path: of the figure; its suffix decides the format.
    """
    drawn = [item for item in QUANTITIES if any(error_of(case, item[0]) for case in result.cases)]
    figure = Figure(figsize=(10.0, 0.6 + 2.8 * max(len(drawn), 1)), layout="constrained")
    panels = figure.subplots(max(len(drawn), 1), 2, squeeze=False, sharex="col", sharey="row")
    materials = [reference.material for reference in result.references]
    for row, (name, label, scale) in zip(panels, drawn, strict=bool(drawn)):
        draw_errors(row[0], result, name, scale, timed=False)
        draw_errors(row[1], result, name, scale, timed=True)
        row[0].set_ylabel(f"error of {label}")
    panels[-1][0].set_xlabel("nodes")
    panels[-1][1].set_xlabel("step without contact [ms]")
    share = 100.0 * result.references[0].equilibria[-1].position
    figure.suptitle(f"{result.robot}, {share:g} % of the largest pull")
    kinds = [Line2D([], [], color=colour, label=element) for element, colour in COLOURS.items()]
    laws = [
        Line2D([], [], color="0.3", label=material, ls=STYLES[i % 4], marker=MARKERS[i % 7], ms=4)
        for i, material in enumerate(materials)
    ]
    figure.legend(handles=[*kinds, *laws], loc="outside lower center", ncols=4, fontsize=8)
    save_figure(figure, path, dpi=150)


def draw_errors(axes: Axes, result: ElementBench, name: str, scale: float, timed: bool) -> None:
    """One curve for each element and material.

    Args:
        axes: to draw on.
        result: the errors and times.
        name: of the quantity.
        scale: from SI to the unit of the axis.
        timed: over the median time of a step, otherwise over nodes.
    """
    for i, reference in enumerate(result.references):
        for element, colour in COLOURS.items():
            points = [
                (case.step_ms.p50 if timed else case.nodes, scale * abs(error))
                for case in result.cases
                if (case.element, case.material) == (element, reference.material)
                and (error := error_of(case, name)) is not None
            ]
            points = sorted(point for point in points if point[1] > EXACT)
            if points:
                axes.plot(
                    *zip(*points, strict=True), color=colour, ls=STYLES[i % 4], marker=MARKERS[i % 7],
                    ms=4, lw=1.2,
                )  # fmt: skip
    axes.set(xscale="log", yscale="log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())
    axes.grid(visible=True, which="both", alpha=0.3)


def error_of(case: ElementCase, name: str) -> float | None:
    """An error at the last pull [SI]; None where there is none.

    Args:
        case: element, material and mesh.
        name: of the quantity.
    """
    last = case.equilibria[-1]
    return {
        "effort": last.tension_error,
        "tip": last.tip_error,
        "contact": last.contact_error,
    }[name]
