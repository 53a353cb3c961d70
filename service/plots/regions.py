"""Figure of the regions of a robot file on its mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from tauten.model import Robot
from tauten.model.mesh import area_normals
from tauten.model.numerics import Array
from tauten.service.check import RegionParts
from tauten.service.plots.body import Side, draw_body, frame
from tauten.service.plots.saving import save_figure

FRONT = Side(0, 1, 1)
COLOUR = np.array([0.84, 0.37, 0.0])
MOST_COLUMNS = 4


def draw_regions(robot: Robot, parts: tuple[RegionParts, ...], path: str | Path) -> None:
    """Draw every region in a panel of its own: its triangles and nodes over a transparent body."""
    columns = min(max(len(parts), 1), MOST_COLUMNS)
    rows = max(-(-len(parts) // columns), 1)
    figure = Figure(figsize=(3.4 * columns, 3.2 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    nodes, triangles = robot.points(robot.rest()), robot.triangles
    for axes, part in zip(panels, parts, strict=False):
        view, count = corner_view(part), len(part.triangles)
        draw_body(axes, nodes @ view, triangles, FRONT, alpha=0.25)
        corners = part.triangles.reshape(-1, 3) @ view
        draw_body(axes, corners, np.arange(3 * count).reshape(-1, 3), FRONT, colour=COLOUR)
        shown = 1e3 * part.nodes @ view
        axes.plot(shown[:, 0], shown[:, 1], ".", color="black", ms=2.0)
        frame(axes, nodes @ view, FRONT)
        axes.set_axis_off()
        axes.set_title(part.name, fontsize=9)
    for axes in panels[len(parts) :]:
        axes.set_axis_off()
    save_figure(figure, path, dpi=150)


def corner_view(part: RegionParts) -> Array:
    """Axes to the right, upwards and towards the eye, seen from the best of eight corners: columns (3, 3)."""
    normals = area_normals(part.triangles)  # (t, 3)
    eyes = np.array([[x, y, z] for z in (0.6, -0.6) for y in (-1.0, 1.0) for x in (0.6, -0.6)])
    eyes /= np.linalg.norm(eyes, axis=1, keepdims=True)
    eye = eyes[int(np.argmax(np.maximum(normals @ eyes.T, 0.0).sum(axis=0).round(12)))]
    right = np.cross([0.0, 0.0, 1.0], eye)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(eye, right), eye], axis=1)
