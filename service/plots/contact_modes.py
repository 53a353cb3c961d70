"""Figure of contact modes on the surface of the robot at rest, as the paper's Fig. 7."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tauten.model import Robot
from tauten.model.numerics import Array
from tauten.reduction.contact import ContactBasis
from tauten.service.plots.saving import save_figure

_PER_ROW = 8
_PITCH, _HEIGHT = 1.25, 4.2  # of a picture [inch]
_SMALL = 0.01  # share of a mode's largest force that is drawn as none


def draw_modes(robot: Robot, basis: ContactBasis, path: str | Path, modes: int = 20) -> None:
    """One picture a mode: candidates coloured by their share of its force, on the pale body.

    Raises:
        BasisError: the basis was made for another robot.
    """
    basis.check_robot(robot)
    shown = min(modes, basis.k)
    rows = -(-shown // _PER_ROW)  # rounded up
    columns = min(shown, _PER_ROW)
    width, height = _PITCH * columns + 1.2, _HEIGHT * rows  # inches; 1.2 for the scale
    figure = Figure(figsize=(width, height))
    points = robot.candidates(robot.rest())
    for i in range(shown):
        row, column = divmod(i, columns)
        # 3D axes fill a square: they may overlap, for bodies are seldom as wide as they are long
        left = ((column + 0.5) * _PITCH - 0.5 * _HEIGHT) / width
        size = (_HEIGHT / width, 0.95 / rows)
        axes = figure.add_axes((left, 1.0 - (row + 1) / rows, *size), projection="3d")
        axes.patch.set_alpha(0.0)
        colours = _draw(axes, robot, points, basis.Psi[:, i] / basis.Psi[:, i].max())
        title = (column + 0.5) * _PITCH / width, 1.0 - (row + 0.05) / rows
        figure.text(*title, f"mode {i + 1}", ha="center")
    scale = figure.add_axes((1.0 - 0.9 / width, 0.3, 0.12 / width, 0.4))
    figure.colorbar(colours, cax=scale, label="force, share of the mode's largest")
    save_figure(figure, path, dpi=110)


def _draw(axes: Any, robot: Robot, points: Array, share: Array) -> Any:
    """Body and candidates, in scale, seen obliquely; share (n_c,) in 0 … 1 is the colour."""
    nodes = robot.points(robot.rest())
    axes.plot_trisurf(
        *nodes.T,
        triangles=robot.triangles,
        color="0.75",
        alpha=0.10,
        edgecolor=(0.3, 0.35, 0.4, 0.10),
        lw=0.3,
    )
    pushing = share > _SMALL
    axes.scatter(*points[~pushing].T, s=0.4, color="0.55", depthshade=False)
    order = np.argsort(share[pushing])  # the strongest last, on top
    strong, shares = points[pushing][order], share[pushing][order]
    colours = axes.scatter(
        *strong.T, s=4.0 + 26.0 * shares, c=shares, cmap="YlOrRd", vmin=0.0, vmax=1.0,
        depthshade=False, linewidths=0.25, edgecolors="0.25",
    )  # fmt: skip
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=1.05)
    axes.view_init(elev=30.0, azim=-50.0)
    axes.set_axis_off()
    return colours
