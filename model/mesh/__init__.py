"""Tetrahedral meshes: reading, checks, refinement, surfaces, regions."""

from tauten.model.mesh.quadratic import QuadraticMesh, quadratic_mesh, read_quadratic_mesh
from tauten.model.mesh.regions import in_box
from tauten.model.mesh.surface import boundary_triangles, spread_points, triangle_areas
from tauten.model.mesh.tet_mesh import EDGES, MeshError, TetMesh, checked, oriented, read_mesh

__all__ = [
    "EDGES",
    "MeshError",
    "QuadraticMesh",
    "TetMesh",
    "boundary_triangles",
    "checked",
    "in_box",
    "oriented",
    "quadratic_mesh",
    "read_mesh",
    "read_quadratic_mesh",
    "spread_points",
    "triangle_areas",
]
