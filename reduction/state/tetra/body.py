"""A robot's elements, cables and contact surface in reduced coordinates, made once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.contact import ContactPair, ContactSet
from tauten.model.materials import COROTATIONAL
from tauten.model.numerics import LANES, Array, Ints
from tauten.model.points import PlacedByMap
from tauten.model.tetra import TetRobot
from tauten.reduction.state.tetra.arrays import Body, Tendons, in_lanes, in_rows
from tauten.reduction.state.tetra.points import gradients_of, integration_points, node_rows


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

    def placed(self, alpha: Array) -> PlacedByMap:
        """The points at a state (r,)."""
        return PlacedByMap(self.at(alpha), self.map)


def sampled_body(robot: TetRobot, Phi: Array, elements: Ints, weights: Array) -> Body:
    """Sampled elements in reduced coordinates.

    Args:
        robot: the full model.
        Phi: (n, r) state modes.
        elements: (s,) element numbers, ascending.
        weights: (s,) factors of their forces.
    """
    points = integration_points(robot)
    kind, constants = points.kind[elements], points.constants[elements]  # (s,), (s, 5)
    volume = weights * points.volume[elements]  # (s,)
    G = gradients_of(robot, points, Phi, elements)  # (9 s, r)
    s, r = len(elements), Phi.shape[1]
    corotational = bool((kind == COROTATIONAL).all())
    lame, stiffness = np.zeros((s, 2)), np.zeros((r, r))
    if corotational:
        lame = volume[:, None] * constants[:, :2]
        weighted = np.repeat(2.0 * lame[:, 1], 9)[:, None] * G  # (9 s, r)
        stiffness = G.T @ weighted
    gradient = in_lanes(G.reshape(s, 9, r).swapaxes(1, 2).reshape(s, r * 9))
    filled = np.minimum(np.arange(len(gradient) * LANES), s - 1)  # lanes past the last repeat it
    return Body(
        elements=s,
        gradient=in_rows(gradient.reshape(-1, r, 9 * LANES)),
        volume=in_lanes(volume[:, None]),
        kind=kind[filled],
        constants=constants[filled],
        lame=in_lanes(lame),
        corotational=corotational,
        turns=bool((kind == COROTATIONAL).any()),
        stiffness=stiffness,
    )


def reduced_tendons(robot: TetRobot, Phi: Array) -> Tendons:
    """The cables in reduced coordinates."""
    cables = robot.actuator_set.cables
    first, y = cables.paths.first, cables.stations(robot.mesh.nodes)
    rows = node_rows(robot, Phi, cables.segment_nodes)
    D = np.einsum("sa,sair->ris", cables.segment_weights, rows)
    return Tendons(
        np.searchsorted(cables.paths.owner, np.arange(cables.n_a + 1)),
        in_rows(D.reshape(Phi.shape[1], -1)),
        (y[first + 1] - y[first]).T.ravel(),
        cables.paths.shortest,
    )


def reduced_stations(robot: TetRobot, Phi: Array) -> ReducedPoints:
    """The stations of the cables in reduced coordinates."""
    cables = robot.actuator_set.cables
    motion = np.einsum("pa,pair->pir", cables.weights, node_rows(robot, Phi, cables.nodes))
    rest = cables.stations(robot.mesh.nodes)
    return ReducedPoints(rest.ravel(), np.ascontiguousarray(motion.reshape(-1, Phi.shape[1])))


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
    return surface, ContactSet(pairs, len(used), old.alarm_distance, old.distance)
