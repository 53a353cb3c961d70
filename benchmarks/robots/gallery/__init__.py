"""Scripts that make the robots of the gallery: meshes and robot files."""

from collections.abc import Callable
from pathlib import Path

from benchmarks.robots.gallery.accordion import make_accordion
from benchmarks.robots.gallery.blocks import grid_cells, joined, tetrahedra, write_mesh
from benchmarks.robots.gallery.diamond import make_diamond
from benchmarks.robots.gallery.gripper import make_gripper
from benchmarks.robots.gallery.pneumatic_finger import make_pneumatic_finger
from benchmarks.robots.gallery.tripod import make_tripod
from benchmarks.robots.gallery.trunk import make_trunk

# Each writes the files of a robot into a folder and returns lines about them.
ROBOTS: dict[str, Callable[[Path], list[str]]] = {
    "trunk": make_trunk,
    "diamond": make_diamond,
    "tripod": make_tripod,
    "pneumatic_finger": make_pneumatic_finger,
    "accordion": make_accordion,
    "gripper": make_gripper,
}

__all__ = ["ROBOTS", "grid_cells", "joined", "tetrahedra", "write_mesh"]
