"""Elements of a robot's bodies, placed in the pattern of its tangent."""

from __future__ import annotations

from tauten.model.system import Pattern
from tauten.model.tetra import (
    BodyParts,
    Elements,
    Solid,
    Viscoelasticity,
    make_solid,
    make_viscoelasticity,
)


def place_elements(body: BodyParts, pattern: Pattern) -> Elements | Solid:
    """The elements in the pattern; linear corotational ones of one material have a kernel of their own."""
    if body.is_plain and not body.is_viscous:
        (part,) = body.domains
        slot, column_length = pattern.blocks(part.nodes)
        gradients, volumes = part.gradients[:, 0].copy(), part.volumes[:, 0].copy()
        return Elements(gradients, volumes, slot, column_length)
    return make_solid(body.domains, body.laws, pattern, body.n_elements)


def place_viscosity(body: BodyParts, elements: Elements | Solid) -> Viscoelasticity | None:
    """Viscous constants at the points of the elements; None for an elastic body."""
    if not body.is_viscous or not isinstance(elements, Solid):
        return None
    return make_viscoelasticity(elements, body.laws, body.viscosities)
