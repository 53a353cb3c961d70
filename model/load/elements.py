"""Elements and materials of a robot file, on its mesh."""

from __future__ import annotations

import numpy as np

from tauten.model.mesh import QuadraticMesh, TetMesh, make_selector
from tauten.model.schema import RobotConfig, RobotFileError
from tauten.model.system import Pattern
from tauten.model.tetra import BodyParts, Elements, Solid, body_parts, make_solid


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
    law = np.zeros(len(mesh.tets), dtype=np.int64)
    density = np.full(len(mesh.tets), config.material.density)
    corners = mesh.corners if isinstance(mesh, QuadraticMesh) else mesh
    selector = make_selector(corners, config.named_regions(), source)
    for index, item in enumerate(config.materials):
        chosen = selector.select_tets(item.region, f"materials.{index}.region")
        law[chosen], density[chosen] = index + 1, item.density
    try:
        return body_parts(mesh, config.mesh.element, laws, law, density)
    except ValueError as error:
        raise RobotFileError(f"{source}: mesh: {error}") from error


def place_elements(body: BodyParts, pattern: Pattern) -> Elements | Solid:
    """The elements in the pattern; linear corotational ones of one material have a kernel of their own."""
    if body.is_plain:
        (part,) = body.domains
        slot, column_length = pattern.blocks(part.nodes)
        gradients, volumes = part.gradients[:, 0].copy(), part.volumes[:, 0].copy()
        return Elements(gradients, volumes, slot, column_length)
    return make_solid(body.domains, body.laws, pattern, body.n_elements)
