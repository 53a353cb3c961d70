"""Surfaces of a robot file, on the mesh of its body."""

from __future__ import annotations

import numpy as np

from tauten.model.mesh import TetMesh, in_box
from tauten.model.numerics import Ints
from tauten.model.schema import RobotFileError, SurfaceSettings


def select_surface(settings: SurfaceSettings, mesh: TetMesh, boundary: Ints, source: str) -> Ints:
    """Boundary triangles of a surface of the robot file: (t, 3).

    Args:
        settings: of the surface.
        mesh: the body.
        boundary: (b, 3) all boundary triangles.
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: there are none.
    """
    corners = mesh.nodes[boundary]  # (t, 3, 3)
    chosen = in_box(corners.mean(axis=1), settings.box)
    if settings.normal is not None:
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        wanted = np.array(settings.normal) / np.linalg.norm(settings.normal)
        chosen &= normals @ wanted >= np.cos(np.radians(settings.max_angle_deg))
    if not chosen.any():
        raise RobotFileError(
            f"{source}: surfaces.{settings.name}: no boundary triangle has its centre in "
            f"{settings.box.lower} to {settings.box.upper}"
            + (f" and points along {settings.normal}" if settings.normal else "")
        )
    return boundary[chosen]
