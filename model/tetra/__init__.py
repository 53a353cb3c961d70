"""Bodies made of tetrahedra."""

from tauten.model.tetra.body import BodyParts, body_parts, join_bodies
from tauten.model.tetra.domains import Domains, deforming_domains, linear_domains
from tauten.model.tetra.elements import Lumping, lumped_mass
from tauten.model.tetra.nodal_body import NodalBody
from tauten.model.tetra.quadratic import quadratic_domains, quadratic_lumped_mass
from tauten.model.tetra.smoothed import smoothed_domains
from tauten.model.tetra.solid import Solid, make_solid
from tauten.model.tetra.tetra_body import TetBody
from tauten.model.tetra.tetrahedra import Tetrahedra
from tauten.model.tetra.viscoelastic import make_viscoelasticity

__all__ = [
    "BodyParts",
    "Domains",
    "Lumping",
    "NodalBody",
    "Solid",
    "TetBody",
    "Tetrahedra",
    "body_parts",
    "join_bodies",
    "linear_domains",
    "lumped_mass",
    "deforming_domains",
    "make_solid",
    "make_viscoelasticity",
    "quadratic_domains",
    "quadratic_lumped_mass",
    "smoothed_domains",
]
