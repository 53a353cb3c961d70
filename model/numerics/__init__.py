"""Numerical kernels that do not depend on robots: arrays, rotations, factorisations, complementarity."""

from tauten.model.numerics.active_set import active_set_forces
from tauten.model.numerics.anderson import Anderson
from tauten.model.numerics.arrays import Array, Bools, Ints, diameter, joined, longest, row_keys
from tauten.model.numerics.dense_cholesky import DenseFactors, cholesky, solve_in_place, solve_rows
from tauten.model.numerics.elimination import eliminate, solve_transposed, solve_upper
from tauten.model.numerics.factorisation import (
    BACKENDS,
    Factorisation,
    FactorisationError,
    HalfSolving,
    installed_backends,
    make_factorisation,
)
from tauten.model.numerics.jit import kernel
from tauten.model.numerics.lcp import LcpResult, complementarity, lcp_forces, solve_lcp
from tauten.model.numerics.linear import solve_linear
from tauten.model.numerics.nnls import coordinates, distances, sparse_nnls
from tauten.model.numerics.polar import (
    LANES,
    mirrored_rotation,
    polar_lanes,
    polar_rotations,
)
from tauten.model.numerics.quaternions import (
    conjugate,
    from_rotation_vector,
    matrix_quaternion,
    moments_at_end,
    normalised,
    product,
    quaternion,
    rotate,
    rotated_by,
    rotation_between,
    rotation_vector,
    rotations_between,
    turned,
)
from tauten.model.numerics.updated_cholesky import (
    append_row,
    back_substitute,
    delete_row,
    forward_substitute,
)
from tauten.model.numerics.vector import (
    Vector3,
    add,
    cross,
    dot,
    length,
    row,
    scale,
    subtract,
    unit,
)

__all__ = [
    "Anderson",
    "Array",
    "BACKENDS",
    "Bools",
    "DenseFactors",
    "Factorisation",
    "FactorisationError",
    "HalfSolving",
    "Ints",
    "LANES",
    "LcpResult",
    "Vector3",
    "active_set_forces",
    "add",
    "append_row",
    "back_substitute",
    "cholesky",
    "complementarity",
    "conjugate",
    "coordinates",
    "cross",
    "delete_row",
    "diameter",
    "distances",
    "dot",
    "eliminate",
    "forward_substitute",
    "from_rotation_vector",
    "installed_backends",
    "joined",
    "kernel",
    "lcp_forces",
    "length",
    "longest",
    "make_factorisation",
    "matrix_quaternion",
    "moments_at_end",
    "mirrored_rotation",
    "normalised",
    "polar_lanes",
    "polar_rotations",
    "product",
    "quaternion",
    "rotate",
    "rotated_by",
    "rotation_between",
    "rotation_vector",
    "rotations_between",
    "row",
    "row_keys",
    "scale",
    "solve_in_place",
    "solve_lcp",
    "solve_linear",
    "solve_rows",
    "solve_transposed",
    "solve_upper",
    "sparse_nnls",
    "subtract",
    "turned",
    "unit",
]
