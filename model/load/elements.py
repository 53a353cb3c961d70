"""Elements and materials of a robot file, on its mesh."""

from __future__ import annotations

import numpy as np

from tauten.model.mesh import QuadraticMesh, TetMesh, in_box
from tauten.model.schema import RobotConfig, RobotFileError
from tauten.model.system import Pattern
from tauten.model.tetra import (
    BodyParts,
    Elements,
    Solid,
    Viscoelasticity,
    body_parts,
    make_solid,
    make_viscoelasticity,
)


def build_body(config: RobotConfig, mesh: TetMesh | QuadraticMesh, source: str) -> BodyParts:
    """The body's domains, each with the law of its region.

    Args:
        config: the robot file.
        mesh: the body.
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: a region of `materials` without elements, or elements that do not fit the mesh.
    """
    laws = [item.elastic_law() for item in (config.material, *config.materials)]
    viscosities = [item.viscous() for item in (config.material, *config.materials)]
    law = np.zeros(len(mesh.tets), dtype=np.int64)
    density = np.full(len(mesh.tets), config.material.density)
    centres = mesh.nodes[mesh.tets[:, :4]].mean(axis=1)  # (e, 3)
    for index, item in enumerate(config.materials):
        chosen = in_box(centres, item.region)
        if not chosen.any():
            raise RobotFileError(
                f"{source}: materials.{index}.region: no element has its centre in "
                f"{item.region.lower} to {item.region.upper}"
            )
        law[chosen], density[chosen] = index + 1, item.density
    try:
        return body_parts(mesh, config.mesh.element, laws, law, density, viscosities)
    except ValueError as error:
        raise RobotFileError(f"{source}: mesh: {error}") from error


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
