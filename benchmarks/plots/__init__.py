"""Figures of benchmarks."""

from benchmarks.plots.closed_loop import draw_case
from benchmarks.plots.contact_basis import draw_contact_basis
from benchmarks.plots.elements import draw_elements
from benchmarks.plots.energy import draw_energy
from benchmarks.plots.posture_errors import draw_posture_errors
from benchmarks.plots.still import draw_still

__all__ = [
    "draw_case",
    "draw_contact_basis",
    "draw_elements",
    "draw_energy",
    "draw_posture_errors",
    "draw_still",
]
