"""Tetrahedral meshes: reading, checks, refinement, surfaces, regions."""

from tauten.model.mesh.groups import CellGroup
from tauten.model.mesh.mesh_files import MeshError, read_triangles
from tauten.model.mesh.quadratic import (
    QuadraticMesh,
    quadratic_faces,
    quadratic_mesh,
    read_quadratic_mesh,
)
from tauten.model.mesh.quality import (
    mean_ratios,
    off_a_line,
    ray_crossings,
    read_unchecked_mesh,
    wall_thickness,
)
from tauten.model.mesh.regions import BodyRange, NodeSelector, Selector, make_selector
from tauten.model.mesh.surface import (
    FACES,
    area_normals,
    boundary_triangles,
    covering_points,
    largest_hole,
    spread_points,
    triangle_areas,
    uncancelled_triangles,
    unit_normals,
    vertex_points,
    welded,
)
from tauten.model.mesh.tet_mesh import (
    EDGES,
    UNITS,
    TetMesh,
    checked,
    join_meshes,
    oriented,
    part_numbers,
    read_mesh,
    require_size,
)
from tauten.model.mesh.triangle_distance import distances_to_triangles

__all__ = [
    "BodyRange",
    "CellGroup",
    "EDGES",
    "FACES",
    "MeshError",
    "NodeSelector",
    "QuadraticMesh",
    "Selector",
    "TetMesh",
    "UNITS",
    "area_normals",
    "boundary_triangles",
    "covering_points",
    "largest_hole",
    "checked",
    "distances_to_triangles",
    "join_meshes",
    "make_selector",
    "mean_ratios",
    "off_a_line",
    "oriented",
    "part_numbers",
    "quadratic_faces",
    "quadratic_mesh",
    "ray_crossings",
    "read_mesh",
    "read_quadratic_mesh",
    "read_triangles",
    "read_unchecked_mesh",
    "require_size",
    "spread_points",
    "triangle_areas",
    "vertex_points",
    "uncancelled_triangles",
    "unit_normals",
    "wall_thickness",
    "welded",
]
