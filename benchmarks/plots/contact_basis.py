"""The contact-basis benchmark as a figure."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.contact_basis import ContactBasisBench
from benchmarks.tables import by_method, pairs_of
from tauten.service.plots import save_figure

_COLOURS = ("#0072b2", "#d55e00", "#e69f00", "#009e73", "#cc79a7", "#666666")
_MEAN, _MAX = 3e-3, 1e-2  # of the robot's size: errors allowed with enrichment


def draw_contact_basis(result: ContactBasisBench, path: Path) -> None:
    """Errors against k for every method, and the held-out paths, into a picture."""
    figure = Figure(figsize=(13.0, 7.5), layout="constrained")
    top, bottom = figure.subfigures(2, 1, height_ratios=(1.0, 1.05), squeeze=False)[:, 0]
    left, middle, right = top.subplots(1, 3)
    labels = (
        (left, "force", "force error ‖S − ΨB‖ / ‖S‖"),
        (middle, "energy", "√ of contact energy lost"),
        (right, "max_mm", "largest tip error, no enrichment [mm]"),
    )
    for axes, what, label in labels:
        _draw_curves(result, axes, what)
        axes.set(xlabel="number of contact modes k", ylabel=label)
    right.axhline(1e-3 * result.size_mm, color="0.4", ls="--", lw=1.0)
    left.legend(fontsize="small")
    _draw_held_out(result, bottom.subplots())
    save_figure(figure, path, dpi=150)


def _draw_curves(result: ContactBasisBench, axes: Axes, what: str) -> None:
    for colour, (name, errors) in zip(_COLOURS, by_method(result).items(), strict=False):
        points = [(e.k, getattr(e, what)) for e in errors if getattr(e, what) is not None]
        if points:
            axes.semilogy(*zip(*points, strict=True), "o-", ms=4, color=colour, label=name)
    axes.grid(visible=True, which="both", alpha=0.25)


def _draw_held_out(result: ContactBasisBench, axes: Axes) -> None:
    """Bars up to the largest error, a line at the mean."""
    pairs = pairs_of(result)
    for offset, colour, name, side in (
        (-0.2, "#d55e00", "without", 0),
        (0.2, "#0072b2", "with", 1),
    ):
        errors = [pair[side] for pair in pairs]
        places = [i + offset for i in range(len(errors))]
        axes.bar(
            places, [e.max_mm or 0.0 for e in errors], 0.36, color=colour, alpha=0.55,
            label=f"{name} enrichment: largest",
        )  # fmt: skip
        axes.plot(
            places, [e.mean_mm or 0.0 for e in errors], "_", ms=14, mew=2.5, color=colour,
            label=f"{name} enrichment: mean",
        )  # fmt: skip
    for share, text in ((_MEAN, "0.3 %"), (_MAX, "1 %")):
        axes.axhline(share * result.size_mm, color="0.4", ls="--", lw=1.0)
        axes.text(len(pairs) - 0.45, share * result.size_mm, text, va="bottom", color="0.3")
    axes.set_yscale("log")
    axes.set_ylim(top=5.0 * axes.get_ylim()[1])  # space for the legend
    axes.set_xticks(range(len(pairs)), [pair[0].path for pair in pairs], rotation=30, ha="right")
    axes.set_ylabel("tip error off the training path [mm]")
    axes.set_xlim(-0.6, len(pairs) + 0.2)
    axes.grid(visible=True, axis="y", alpha=0.25)
    axes.legend(ncols=4, fontsize="small", loc="upper left")
