"""Figures of errors: of meshes against their nodes, of contact modes against their number."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from tauten.reduction.contact import Curve
from tauten.service.check import MeshErrorEstimate
from tauten.service.plots.saving import save_figure

COLOURS = {"linear": "#d55e00", "smoothed": "#009e73", "quadratic": "#0072b2"}
QUANTITIES = (
    ("effort", "tension [%]", 1e2),
    ("tip", "tip [mm]", 1e3),
    ("contact", "contact force [%]", 1e2),
)
EXACT = 1e-6  # errors are drawn on a logarithmic scale; the reference's own are zero


def draw_mesh_error(estimate: MeshErrorEstimate, path: str | Path) -> None:
    """Draw the largest error of effort, tip and contact force over the nodes of each mesh."""
    figure = Figure(figsize=(10.0, 3.4), layout="constrained")
    quantities = [
        item
        for item in QUANTITIES
        if any(getattr(variant, item[0]) is not None for variant in estimate.variants)
    ]
    panels = figure.subplots(1, max(len(quantities), 1), squeeze=False)[0]
    for axes, (name, label, scale) in zip(panels, quantities, strict=bool(quantities)):
        draw_quantity(axes, estimate, name, scale)
        axes.set_xlabel("nodes")
        label = f"{estimate.effort_name} [%]" if name == "effort" else label
        axes.set_ylabel(f"largest error of {label}")
        axes.grid(visible=True, which="both", alpha=0.3)
        whole_decades(axes)
    handles, labels = panels[0].get_legend_handles_labels()
    if handles:
        panels[0].legend(handles, labels)
    save_figure(figure, path, dpi=150)


def draw_quantity(axes: Axes, estimate: MeshErrorEstimate, name: str, scale: float) -> None:
    """One curve for each kind of element; the mesh that is the reference itself is left out.

    Args:
        axes: to draw on.
        estimate: the errors.
        name: of the quantity.
        scale: from SI to the unit of the axis.
    """
    for element, colour in COLOURS.items():
        points = [
            (item.nodes, scale * abs(getattr(item, name)))
            for item in estimate.variants
            if item.variant.element == element and getattr(item, name) is not None
        ]
        points = sorted(point for point in points if point[1] > EXACT)
        if points:
            axes.loglog(*zip(*points, strict=True), "o-", color=colour, label=element)


def whole_decades(axes: Axes) -> None:
    """Limits at powers of ten, and labels at these alone."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis, limits in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        low, high = np.log10(limits)
        axis.set_minor_formatter(NullFormatter())
        axis.set_view_interval(10.0 ** np.floor(low), 10.0 ** np.ceil(high), ignore=True)


def draw_curve(curve: Curve, path: str | Path, chosen: int | None = None) -> None:
    """Draw energy error and held-out effector error over k."""
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    energy, tip = figure.subplots(1, 2)
    energy.semilogy(curve.k, curve.training, "o-", color="#0072b2", label="training")
    energy.semilogy(curve.k, curve.held_out, "s-", color="#d55e00", label="held out")
    energy.set_ylabel("√ of the contact energy lost")
    tip.semilogy(curve.k, 1e3 * curve.tip, "s-", color="#d55e00", label="held out, largest")
    tip.set_ylabel("effector error, first order [mm]")
    for axes in (energy, tip):
        if chosen is not None:
            axes.axvline(chosen, color="0.6", linestyle="--", label=f"k = {chosen}")
        axes.set_xlabel("number of contact modes k")
        axes.grid(visible=True, which="both", alpha=0.3)
        axes.legend()
    save_figure(figure, path, dpi=150)
