"""Smoothed linear tetrahedra: the deformation gradient averaged around edges or nodes.

A domain owns an equal share of every tetrahedron around it: a sixth around an edge, a quarter around a
node. Its deformation gradient is the average of theirs by volume, F_k = Σ V_e F_e / Σ V_e = Σ x_a ḡ_aᵀ,
with averaged gradients ḡ_a, so the degrees of freedom are those of the linear mesh. Averages around edges
remove most of the stiffness linear tetrahedra have in bending; averages around nodes remove their locking
where the volume can hardly change.

Sources: Nguyen-Thoi, Liu, Lam and Zhang, A face-based smoothed finite element method, International Journal
for Numerical Methods in Engineering 78, 2009; Cazes and Meschke, An edge-based smoothed finite element method
for 3D analysis of solid mechanics problems, the same 94, 2013.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from tauten.model.mesh import TetMesh
from tauten.model.numerics import Ints, row_keys
from tauten.model.tetra.domains import Domains
from tauten.model.tetra.elements import rest_gradients

Around = Literal["edge", "node"]
CORNERS: dict[Around, list[tuple[int, ...]]] = {
    "edge": [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)],
    "node": [(0,), (1,), (2,), (3,)],
}


def smoothed_domains(mesh: TetMesh, law: Ints, around: Around) -> list[Domains]:
    """Smoothed domains, one `Domains` for each number of nodes.

    Args:
        mesh: linear tetrahedra.
        law: (e,) index of the law of each tetrahedron; where laws meet, each has a domain of its own.
        around: what the domains surround.
    """
    e, parts = len(mesh.tets), len(CORNERS[around])
    corners = np.sort(mesh.tets[:, np.array(CORNERS[around])], axis=2)  # (e, parts, c)
    keys = np.concatenate([corners, np.broadcast_to(law[:, None, None], (e, parts, 1))], axis=2)
    keys = keys.reshape(e * parts, -1)
    _, first, domain = np.unique(row_keys(keys), return_index=True, return_inverse=True)
    element = np.repeat(np.arange(e), parts)
    share = np.repeat(mesh.volumes / parts, parts)
    volumes = np.bincount(domain, share).astype(float)  # (d,)
    # entries: the nodes of each domain, with their averaged gradients
    weight = (share / volumes[domain])[:, None, None]
    pairs = np.stack([np.repeat(domain, 4), mesh.tets[element].ravel()], axis=1)
    _, place, entry = np.unique(row_keys(pairs), return_index=True, return_inverse=True)
    entries = pairs[place]
    values = np.zeros((len(entries), 3))
    np.add.at(values, entry, (weight * rest_gradients(mesh)[element]).reshape(-1, 3))
    count = np.bincount(entries[:, 0])  # (d,) nodes of each domain
    start = np.cumsum(count) - count
    domains = []
    for s in np.unique(count):
        chosen = np.flatnonzero(count == s)
        rows = start[chosen][:, None] + np.arange(s)  # (d, s)
        domains.append(
            Domains(
                nodes=entries[rows, 1],
                gradients=np.ascontiguousarray(values[rows][:, None]),
                volumes=volumes[chosen][:, None].copy(),
                law=keys[first[chosen], -1].copy(),
            )
        )
    return domains
