"""Tetrahedral meshes: reading, checks, refinement, surfaces, regions."""

from tauten.model.mesh.regions import in_box
from tauten.model.mesh.surface import boundary_triangles, spread_points, triangle_areas
from tauten.model.mesh.tet_mesh import MeshError, TetMesh, checked, oriented, read_mesh

__all__ = [
    "MeshError",
    "TetMesh",
    "boundary_triangles",
    "checked",
    "in_box",
    "oriented",
    "read_mesh",
    "spread_points",
    "triangle_areas",
]
