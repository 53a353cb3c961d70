"""Figure of the error against the number of modes."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from tauten.reduction.contact import Curve
from tauten.service.plots.saving import save_figure


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
