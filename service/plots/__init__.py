"""Figures."""

from tauten.service.plots.body import Side, draw_body, draw_forces, frame
from tauten.service.plots.contact_modes import draw_modes
from tauten.service.plots.error_curve import draw_curve
from tauten.service.plots.run import draw_run, widest_plane

__all__ = [
    "Side",
    "draw_body",
    "draw_curve",
    "draw_forces",
    "draw_modes",
    "draw_run",
    "frame",
    "widest_plane",
]
