"""Writes `bender.stl`, the part of the tutorial "Your own robot": a bar with five notches, in millimetres.

    python examples/make_bender.py

It needs netgen (`pip install -e '.[mesh]'`), whose geometry kernel cuts the notches.
"""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
from netgen.occ import Box, OCCGeometry

WIDTH, LENGTH = 15.0, 100.0  # mm
SPINE, GAP = 5.0, 4.0  # mm, thickness of what is left behind a notch, and its width
NOTCHES = (18.0, 35.0, 52.0, 69.0, 86.0)  # mm along the bar
FACETS = 6.0  # mm, longest edge of a triangle


def main() -> None:
    """Cut the notches and write the surface beside this file."""
    bar = Box((0, 0, 0), (WIDTH, WIDTH, LENGTH))
    for middle in NOTCHES:
        bar = bar - Box((SPINE, -1, middle - GAP / 2), (WIDTH + 1, WIDTH + 1, middle + GAP / 2))
    mesh = OCCGeometry(bar).GenerateMesh(maxh=FACETS)
    points = np.array([point.p for point in mesh.Points()])
    triangles = np.array(
        [[corner.nr - 1 for corner in face.vertices] for face in mesh.Elements2D()]
    )
    used, numbers = np.unique(triangles, return_inverse=True)
    surface = meshio.Mesh(points[used], [("triangle", numbers.reshape(-1, 3))])
    surface.write(Path(__file__).with_name("bender.stl"), binary=True)


if __name__ == "__main__":
    main()
