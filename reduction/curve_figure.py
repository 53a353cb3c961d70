"""Figure of the error against the number of modes."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from tauten.reduction.choose import Curve


def draw_curve(curve: Curve, path: str | Path, chosen: int | None = None) -> None:
    """Relative force error against k, training and held out, the chosen k marked."""
    figure = Figure(figsize=(6.0, 4.0), layout="constrained")
    axes = figure.subplots()
    axes.semilogy(curve.k, curve.training, "o-", label="training")
    axes.semilogy(curve.k, curve.held_out, "s-", label="held out")
    if chosen is not None:
        axes.axvline(chosen, color="0.6", linestyle="--", label=f"k = {chosen}")
    axes.set_xlabel("number of contact modes k")
    axes.set_ylabel("force error ‖S − ΨB‖ / ‖S‖")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=150)
