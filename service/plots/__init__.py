"""Figures; the suffix of a file decides its format."""

from tauten.service.plots.body import Side
from tauten.service.plots.comparison import draw_comparison
from tauten.service.plots.contact_modes import draw_modes
from tauten.service.plots.errors import (
    COLOURS,
    EXACT,
    QUANTITIES,
    draw_curve,
    draw_mesh_error,
)
from tauten.service.plots.regions import draw_regions
from tauten.service.plots.run import draw_distances, draw_replay, draw_run, widest_plane
from tauten.service.plots.saving import save_figure

__all__ = [
    "COLOURS",
    "EXACT",
    "QUANTITIES",
    "Side",
    "draw_comparison",
    "draw_curve",
    "draw_distances",
    "draw_mesh_error",
    "draw_modes",
    "draw_regions",
    "draw_replay",
    "draw_run",
    "save_figure",
    "widest_plane",
]
