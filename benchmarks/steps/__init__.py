"""Times of whole steps: with each kind of contact, on SOFA's meshes, of the gallery."""

from benchmarks.steps.control import ControlBench, bench_control
from benchmarks.steps.gallery import GalleryBench, GalleryRow, LoadRow, bench_gallery
from benchmarks.steps.load_comparison import ForeignLoadError, load_errors
from benchmarks.steps.sofa_meshes import SofaMeshBench, bench_sofa_meshes

__all__ = [
    "ForeignLoadError",
    "load_errors",
    "ControlBench",
    "GalleryBench",
    "GalleryRow",
    "LoadRow",
    "SofaMeshBench",
    "bench_control",
    "bench_gallery",
    "bench_sofa_meshes",
]
