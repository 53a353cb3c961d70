"""From a mesh, an element and laws to domains of integration and masses."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model.materials import ELASTIC, Law, Viscosity
from tauten.model.mesh import QuadraticMesh, TetMesh, quadratic_mesh
from tauten.model.numerics import Array, Ints, joined
from tauten.model.schema import ElementName
from tauten.model.tetra.domains import Domains, linear_domains
from tauten.model.tetra.elements import Lumping, lumped_mass, lumping
from tauten.model.tetra.quadratic import SHARES, quadratic_domains, quadratic_lumped_mass
from tauten.model.tetra.smoothed import smoothed_domains


@dataclass(frozen=True, slots=True)
class BodyParts:
    """Mesh, elements and laws of a body, before their places in the sparsity pattern are known.

    Attributes:
        mesh: linear tetrahedra on all nodes; quadratic elements are cut into eight.
        domains: domains of integration.
        laws: what their `law` points to.
        mass: (n_nodes,) lumped mass [kg].
        n_elements: tetrahedra, before quadratic ones are cut.
        viscosities: of each law.
        lumpings: what lumping the mass of its elements changes.
    """

    mesh: TetMesh
    domains: list[Domains]
    laws: list[Law]
    mass: Array
    n_elements: int
    viscosities: list[Viscosity]
    lumpings: list[Lumping]

    @property
    def is_viscous(self) -> bool:
        """Whether any of its materials is viscous."""
        return any(item != ELASTIC for item in self.viscosities)


def body_parts(
    mesh: TetMesh | QuadraticMesh,
    element: ElementName,
    laws: list[Law],
    law: Ints,
    density: Array,
    viscosities: list[Viscosity],
) -> BodyParts:
    """Domains of a body.

    Smoothed bodies average the part of each law with λ = 0 around edges and the rest around nodes.

    Args:
        mesh: its tetrahedra; linear ones get midpoints where `element` is quadratic.
        element: what is made of them.
        laws: the laws.
        law: (e,) which law each tetrahedron has.
        density: (e,) [kg/m³].
        viscosities: of each law.
    """
    if element == "quadratic":
        quadratic = quadratic_mesh(mesh) if isinstance(mesh, TetMesh) else mesh
        domains = quadratic_domains(quadratic, law)
        mass = quadratic_lumped_mass(domains, density, len(quadratic.nodes))
        own = density * domains.volumes.sum(axis=1)
        lumped = [lumping(quadratic.nodes, quadratic.tets, own, SHARES)]
        whole, count = quadratic.split(), len(quadratic.tets)
        return BodyParts(whole, [domains], laws, mass, count, viscosities, lumped)
    if isinstance(mesh, QuadraticMesh):
        raise ValueError(f"{element} elements need a mesh of linear tetrahedra")
    mass, count = lumped_mass(mesh, density), len(mesh.tets)
    lumped = [lumping(mesh.nodes, mesh.tets, density * mesh.volumes, np.full(4, 0.25))]
    if element == "linear":
        linear = [linear_domains(mesh, law)]
        return BodyParts(mesh, linear, laws, mass, count, viscosities, lumped)
    shear, volume = zip(*(item.parts() for item in laws), strict=True)
    parts = smoothed_domains(mesh, law, "edge") + smoothed_domains(mesh, law + len(laws), "node")
    slow, slower = zip(*(item.parts() for item in viscosities), strict=True)
    return BodyParts(mesh, parts, [*shear, *volume], mass, count, [*slow, *slower], lumped)


def join_bodies(parts: list[BodyParts], mesh: TetMesh) -> BodyParts:
    """Several bodies as one; domains of the same shape and laws that are equal become one."""
    if len(parts) == 1:
        return parts[0]
    laws: list[tuple[Law, Viscosity]] = []
    shapes: dict[tuple[int, ...], list[Domains]] = {}
    first, lumpings = 0, list[Lumping]()
    for part in parts:
        own = list(zip(part.laws, part.viscosities, strict=True))
        laws += [law for law in own if law not in laws]
        number = np.array([laws.index(law) for law in own], dtype=np.int64)
        for domains in part.domains:
            moved = replace(domains, nodes=domains.nodes + first, law=number[domains.law])
            shapes.setdefault(domains.gradients.shape[1:3], []).append(moved)
        lumpings += [replace(one, nodes=one.nodes + first) for one in part.lumpings]
        first += len(part.mesh.nodes)
    mass = np.concatenate([part.mass for part in parts])
    return BodyParts(
        mesh,
        [joined(same) for same in shapes.values()],
        [law for law, _ in laws],
        mass,
        sum(part.n_elements for part in parts),
        [viscosity for _, viscosity in laws],
        lumpings,
    )
