"""A robot's elements, cables and contact surface in reduced coordinates, made once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.contact import ContactPair, ContactSet
from tauten.model.numerics import Array, Ints
from tauten.model.tetra import TetRobot
from tauten.reduction.state.kernels import Body, Tendons


@dataclass(frozen=True, slots=True, eq=False)
class ReducedPoints:
    """Points that move with the reduced state: x = x₀ + map α.

    Attributes:
        rest: (3 p,) positions in the rest state [m].
        map: (3 p, r).
    """

    rest: Array
    map: Array

    def at(self, alpha: Array) -> Array:
        """Positions (p, 3) [m]."""
        positions: Array = (self.rest + self.map @ alpha).reshape(-1, 3)
        return positions


def node_rows(robot: TetRobot, Phi: Array, nodes: Ints) -> Array:
    """Rows of Φ that belong to nodes, zero where a node is fixed.

    Args:
        robot: the full model.
        Phi: (n, r) state modes.
        nodes: (…,) node numbers.

    Returns:
        (…, 3, r).
    """
    first = robot.pattern.dof[nodes]
    rows = Phi[np.maximum(first, 0)[..., None] + np.arange(3)]
    return np.where((first >= 0)[..., None, None], rows, 0.0)


def sampled_body(robot: TetRobot, Phi: Array, elements: Ints, weights: Array) -> Body:
    """Sampled elements in reduced coordinates.

    Args:
        robot: the full model.
        Phi: (n, r) state modes.
        elements: (s,) element numbers.
        weights: (s,) factors of their forces.
    """
    G = element_gradients(robot, Phi, elements)  # (9 s, r)
    volume = weights * robot.corotational.volumes[elements]  # (s,)
    weighted = np.repeat(2.0 * robot.material.lame[1] * volume, 9)[:, None] * G  # (9 s, r)
    identity = np.tile(np.eye(3).ravel(), len(elements))  # (9 s,)
    return Body(G, volume, robot.material.lame, G.T @ weighted, identity @ weighted)


def element_gradients(robot: TetRobot, Phi: Array, elements: Ints) -> Array:
    """Derivatives of the deformation gradients F_ij with respect to α.

    Args:
        robot: the full model.
        Phi: (n, r) state modes.
        elements: (s,) element numbers.

    Returns:
        (9 s, r) [1/m], row 9 e + 3 i + j.
    """
    rows = node_rows(robot, Phi, robot.mesh.tets[elements])  # (s, 4, 3, r)
    G = np.einsum("sair,saj->sijr", rows, robot.corotational.gradients[elements], optimize=True)
    return np.ascontiguousarray(G.reshape(-1, Phi.shape[1]))


def reduced_tendons(robot: TetRobot, Phi: Array) -> Tendons:
    """The cables in reduced coordinates."""
    cables = robot.cables
    D = np.einsum("sa,sair->sir", cables.weights, node_rows(robot, Phi, cables.nodes))
    rest = cables.offset + np.einsum("sa,sai->si", cables.weights, robot.mesh.nodes[cables.nodes])
    return Tendons(
        cables.owner,
        np.ascontiguousarray(D.reshape(-1, Phi.shape[1])),
        rest.ravel(),
        cables.rest_length,
    )


def contact_surface(robot: TetRobot, Phi: Array) -> tuple[ReducedPoints, ContactSet]:
    """The vertices that contacts refer to, and the contacts on these vertices only."""
    old = robot.contacts
    parts = [part.ravel() for pair in old.pairs for part in (pair.nodes, pair.triangles)]
    used = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *parts]))  # (v,)

    def number(vertices: Ints) -> Ints:
        return np.searchsorted(used, vertices)

    pairs = [
        ContactPair(pair.name, number(pair.nodes), pair.weights, number(pair.triangles), pair.apart)
        for pair in old.pairs
    ]
    rows = node_rows(robot, Phi, used).reshape(-1, Phi.shape[1])
    surface = ReducedPoints(robot.mesh.nodes[used].ravel(), np.ascontiguousarray(rows))
    return surface, ContactSet(pairs, len(used), old.alarm_distance)
