"""The part that becomes a robot's body: a surface, a solid or tetrahedra in a file, in metres."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from tauten.model.actuators import enclosed_volume
from tauten.model.mesh import (
    oriented,
    read_triangles,
    read_unchecked_mesh,
    uncancelled_triangles,
    welded,
)
from tauten.model.numerics import Array, Ints
from tauten.service.new.crossing import first_crossing
from tauten.service.process import Progress

SURFACES = (".stl", ".obj", ".ply")
SOLIDS = (".step", ".stp", ".brep")
Kind = Literal["surface", "solid", "tetrahedra"]
MOST_TRIANGLES = 1_000_000  # of a surface; a mesher takes hours for more


class PartError(ValueError):
    """A part that cannot become a body; the text names the file and the next step."""


@dataclass(frozen=True, slots=True)
class Surface:
    """A closed surface, seen from outside counter-clockwise.

    Attributes:
        vertices: (v, 3) in the unit of the file.
        triangles: (t, 3) vertex ids.
        note: what was changed in it; "" for nothing.
    """

    vertices: Array
    triangles: Ints
    note: str = ""

    @property
    def volume(self) -> float:
        """Enclosed volume, in the unit of the file."""
        return enclosed_volume(self.vertices, self.triangles)


def kind_of(path: Path) -> Kind:
    """What a file holds, by its suffix; everything that is no surface and no solid is read by meshio."""
    suffix = path.suffix.lower()
    if suffix in SURFACES:
        return "surface"
    return "solid" if suffix in SOLIDS else "tetrahedra"


def read_surface(path: Path, repair: bool, progress: Progress) -> Surface:
    """Read a closed surface.

    Raises:
        MeshError: unreadable file, no triangles, or numbers that are not finite.
        PartError: too many triangles, or none whose corners differ; holes, parts inside out relative to one
            another, self-intersections.
    """
    points, corners = read_triangles(path)
    if len(corners) > MOST_TRIANGLES:
        raise PartError(
            f"{path}: the surface has {len(corners)} triangles, allowed are {MOST_TRIANGLES}; export it "
            "with a larger deviation, or the solid as STEP"
        )
    vertices, triangles = welded(points[corners])
    if not len(triangles):
        raise PartError(
            f"{path}: each of its {len(corners)} triangles has two corners at the same point; export the "
            "surface again, with more digits"
        )
    if repair:
        return Surface(vertices, triangles, "repaired by the mesher")
    refuse_holes(path, triangles)
    note = ""
    if enclosed_volume(vertices, triangles) < 0.0:
        triangles, note = triangles[:, ::-1].copy(), "was inside out and has been turned"
    crossing = first_crossing(vertices, triangles, progress)
    if crossing is not None:
        where = np.round(vertices[triangles[crossing[0]]].mean(axis=0), 4).tolist()
        raise PartError(
            f"{path}: triangles {crossing[0]} and {crossing[1]} cross each other near {where} (unit of the "
            "file); mend the surface in CAD, or let the mesher do it with --repair"
        )
    return Surface(vertices, triangles, note)


def read_outside(path: Path) -> Surface:
    """The outside of a volume mesh, for the mesher that accepts holes and crossings.

    Raises:
        MeshError: unreadable file, or no tetrahedra.
    """
    mesh = read_unchecked_mesh(path)
    tets = oriented(mesh.nodes, mesh.tets)
    return Surface(
        mesh.nodes, uncancelled_triangles(tets), "was meshed anew from that of its tetrahedra"
    )


def refuse_holes(path: Path, triangles: Ints) -> None:
    """Raise a PartError unless each edge has two triangles that pass it in opposite directions."""
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])  # (3 t, 2)
    _, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    advice = "close the surface in CAD, or let the mesher do it with --repair"
    if (count == 1).any():
        raise PartError(
            f"{path}: the surface has holes, {int((count == 1).sum())} edges have one triangle; {advice}"
        )
    if (count > 2).any():
        raise PartError(
            f"{path}: {int((count > 2).sum())} edges have more than two triangles; {advice}"
        )
    _, turned = np.unique(edges, axis=0, return_counts=True)
    if (turned > 1).any():
        raise PartError(
            f"{path}: some triangles are inside out beside others, {int((turned > 1).sum())} edges; {advice}"
        )
