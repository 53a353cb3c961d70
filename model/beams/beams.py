"""The body of a robot made of beams: nodes, elements between them, masses on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import Rotation

from tauten.model.beams.elements import BeamArrays
from tauten.model.beams.profile import Material, Profile, natural_stiffness
from tauten.model.numerics import Array, Ints, diameter


class BeamError(ValueError):
    """Beams that do not form a body; the text names them and what is allowed."""


@dataclass(frozen=True, slots=True)
class Beams:
    """Beams at rest, all nodes turned like the world.

    Attributes:
        nodes: (n_nodes, 3) positions [m].
        ends: (e, 2) nodes of each element.
        axes: (e, 4) unit quaternions, turn from an element's axes to the world's.
        D: (e, 6) stiffnesses of the natural modes, see `profile.natural_stiffness`.
        length: (e,) [m].
        mass: (n_nodes,) lumped mass [kg].
        inertia: (n_nodes,) lumped rotary inertia [kg m²], that of the cross-sections about the beam. It is
            the same about all axes: across the beam the masses of the nodes have nearly all of it.
    """

    nodes: Array
    ends: Ints
    axes: Array
    D: Array
    length: Array
    mass: Array
    inertia: Array

    @property
    def arrays(self) -> BeamArrays:
        """The elements as kernels take them."""
        return BeamArrays(self.ends, self.axes, self.D, self.length)

    @property
    def size(self) -> float:
        """Largest distance between two nodes [m]."""
        return diameter(self.nodes)


def make_beams(
    nodes: Array, ends: Ints, up: Array, profiles: list[Profile], material: Material
) -> Beams:
    """Beams of one material.

    Args:
        nodes: (n_nodes, 3) positions at rest [m].
        ends: (e, 2) nodes of each element.
        up: (e, 3) a direction near axis 3 of each element's cross-section.
        profiles: cross-section of each element.
        material: of all beams.

    Raises:
        BeamError: an end that is no node, a beam without length, a node that no beam leads to.
    """
    if len(ends) == 0 or ends.min() < 0 or ends.max() >= len(nodes):
        raise BeamError(f"beams need ends among the nodes 0 to {len(nodes) - 1}")
    along = nodes[ends[:, 1]] - nodes[ends[:, 0]]  # (e, 3)
    length = np.linalg.norm(along, axis=1)
    size = diameter(nodes)
    short = np.flatnonzero(length <= 1e-6 * size)
    if len(short):
        a, b = ends[short[0]]
        raise BeamError(
            f"beams.{short[0]} from node {a} to node {b} has a length of {length[short[0]]:.3g} m, "
            f"allowed is more than {1e-6 * size:.3g} m"
        )
    check_connected(len(nodes), ends)
    mass, inertia = np.zeros(len(nodes)), np.zeros(len(nodes))
    for (a, b), profile, L in zip(ends, profiles, length, strict=True):
        line = material.density * profile.area if profile.mass is None else profile.mass
        half = 0.5 * line * L
        polar = sum(profile.bending) / profile.area  # m²
        for node in (a, b):
            mass[node] += half
            inertia[node] += half * polar
    D = np.array([natural_stiffness(p, material, L) for p, L in zip(profiles, length, strict=True)])
    return Beams(nodes, ends, element_axes(along / length[:, None], up), D, length, mass, inertia)


def check_connected(n_nodes: int, ends: Ints) -> None:
    """Raise a BeamError that names a node which beams do not join to node 0."""
    graph = sp.coo_array((np.ones(len(ends)), ends.T), shape=(n_nodes, n_nodes))
    parts, label = connected_components(graph, directed=False)
    if parts > 1:
        lost = np.flatnonzero(label != label[0])
        raise BeamError(
            f"node {lost[0]} is not connected to node 0: the beams fall into {parts} parts, "
            "allowed is one"
        )


def element_axes(along: Array, up: Array) -> Array:
    """Quaternions (e, 4) of axes along (e, 3), across, and near up (e, 3).

    Raises:
        BeamError: up lies along a beam.
    """
    across = np.cross(up, along)
    sine = np.linalg.norm(across, axis=1, keepdims=True)
    flat = np.flatnonzero(sine[:, 0] <= 1e-6 * np.linalg.norm(up, axis=1))
    if len(flat):
        raise BeamError(f"beams.{flat[0]}: up {up[flat[0]].tolist()} lies along the beam")
    across = across / sine
    frames = np.stack([along, across, np.cross(along, across)], axis=2)  # (e, 3, 3), columns
    axes: Array = Rotation.from_matrix(frames).as_quat()[:, [3, 0, 1, 2]]
    return axes
