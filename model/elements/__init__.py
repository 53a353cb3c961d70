"""Elements as domains of integration: linear, quadratic and smoothed tetrahedra of any material."""

from tauten.model.elements.domains import Domains, assemble_domains
from tauten.model.elements.quadratic import (
    quadratic_domains,
    quadratic_lumped_mass,
    shape_functions,
)
from tauten.model.elements.smoothed import smoothed_domains
from tauten.model.elements.solid import Solid, make_solid

__all__ = [
    "Domains",
    "Solid",
    "assemble_domains",
    "make_solid",
    "quadratic_domains",
    "quadratic_lumped_mass",
    "shape_functions",
    "smoothed_domains",
]
