"""A robot's elements, cables and contact surface in reduced coordinates, made once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model import Robot
from tauten.model.contact import ContactSet
from tauten.model.materials import COROTATIONAL, N_CONSTANTS
from tauten.model.numerics import LANES, Array, Ints
from tauten.model.points import (
    Entries,
    MeanPoints,
    NodePoints,
    Placed,
    dense_units,
    mapped_rows,
    points_at,
)
from tauten.model.tetra import TetBody, Tetrahedra
from tauten.reduction.state.tetra.arrays import SampledElements, Tendons, in_lanes, in_rows
from tauten.reduction.state.tetra.own_motion import Derivative
from tauten.reduction.state.tetra.points import gradients_of, integration_points, node_rows


@dataclass(frozen=True, slots=True, eq=False)
class ModePoints:
    """Points that move with the reduced state: x = x₀ + map β.

    Attributes:
        rest: (3 p,) positions in the rest state [m].
        map: (3 p, R).
    """

    rest: Array
    map: Array


@dataclass(frozen=True, slots=True, eq=False)
class ModeMotion:
    """A body moved by modes at one state, a `Motion` of `ModePoints`.

    Attributes:
        beta: (R,) how much each mode moves it [m].
        J: (R, n) ∂β/∂q; None: β are the unknowns.
        travel: (d,) values of the coordinates that motors move directly.
    """

    beta: Array
    J: Derivative | None
    travel: Array

    @property
    def n(self) -> int:
        """Unknowns."""
        return len(self.beta) if self.J is None else self.J.n

    def placed(self, points: ModePoints) -> PlacedByModes:
        """Points of the body at this state."""
        y = (points.rest + points.map @ self.beta).reshape(-1, 3)
        return PlacedByModes(y, points.map, self.J)

    def units(self, columns: Ints) -> Array:
        """Unit rows (m, n) of some unknowns (m,)."""
        return dense_units(columns, self.n)


@dataclass(frozen=True, slots=True, eq=False)
class PlacedByModes(Placed):
    """Points moved by modes at one state.

    Attributes, beside those of all placed points:
        map: (3 p, R) their derivative by β.
        J: (R, n) ∂β/∂q; None: β are the unknowns.
    """

    map: Array
    J: Derivative | None

    def rows(self, entries: Entries) -> Array:
        """Rows (m, n) over the unknowns, of rows over these points."""
        H = np.zeros((len(entries.starts) - 1, self.map.shape[1]))
        mapped_rows(entries.starts, entries.points, entries.vectors, self.map, H)
        return H if self.J is None else self.J.rows(H)

    def motion(self) -> Array:
        """Derivative of the positions by the unknowns: (3 p, n)."""
        return self.map if self.J is None else self.J.rows(self.map)


def mode_points(tetrahedra: Tetrahedra, Phi: Array, points: NodePoints | MeanPoints) -> ModePoints:
    """Points of a body in reduced coordinates.

    Args:
        tetrahedra: of the full model.
        Phi: (n, R) state modes.
        points: of the full model.
    """
    rest = points.at(tetrahedra.mesh.nodes).ravel()
    if isinstance(points, MeanPoints):
        return ModePoints(rest, np.asarray(points.C @ Phi))
    rows = node_rows(tetrahedra, Phi, points.nodes)
    motion = np.einsum("pa,pair->pir", points.weights, rows).reshape(-1, Phi.shape[1])
    return ModePoints(rest, np.ascontiguousarray(motion))


def sampled_body(
    tetrahedra: Tetrahedra, Phi: Array, elements: Ints, weights: Array
) -> SampledElements:
    """Sampled elements in reduced coordinates.

    Args:
        tetrahedra: of the full model.
        Phi: (n, r) state modes.
        elements: (s,) element numbers, ascending.
        weights: (s,) factors of their forces.
    """
    points = integration_points(tetrahedra)
    kind, constants = points.kind[elements], points.constants[elements]  # (s,), (s, 7)
    volume = weights * points.volume[elements]  # (s,)
    G = gradients_of(tetrahedra, points, Phi, elements)  # (9 s, r)
    s, r = len(elements), Phi.shape[1]
    corotational = bool((kind == COROTATIONAL).all())
    lame, stiffness = volume[:, None] * constants[:, N_CONSTANTS:], np.zeros((r, r))
    if corotational:
        weighted = np.repeat(2.0 * lame[:, 1], 9)[:, None] * G  # (9 s, r)
        stiffness = G.T @ weighted
    gradient = in_lanes(G.reshape(s, 9, r).swapaxes(1, 2).reshape(s, r * 9))
    filled = np.minimum(np.arange(len(gradient) * LANES), s - 1)  # lanes past the last repeat it
    return SampledElements(
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


def reduced_tendons(tetrahedra: Tetrahedra, Phi: Array) -> Tendons:
    """The cables in reduced coordinates."""
    curvature, x0 = tetrahedra.curvature, tetrahedra.mesh.nodes
    paths, y = curvature.actuators.paths, curvature.actuators.stations.at(x0)
    rows = node_rows(tetrahedra, Phi, curvature.ends)
    D = np.einsum("sa,sair->ris", curvature.weights, rows)
    return Tendons(
        np.searchsorted(paths.owner, np.arange(paths.n_a + 1)),
        in_rows(D.reshape(Phi.shape[1], -1)),
        (y[paths.first + 1] - y[paths.first]).T.ravel(),
        paths.shortest,
    )


def contact_surface(robot: Robot[TetBody], Phi: Array) -> tuple[ModePoints, ContactSet]:
    """The vertices that contacts refer to, and the contacts on these vertices only."""
    old = robot.contacts
    parts = [part.ravel() for pair in old.pairs for part in (pair.nodes, pair.triangles)]
    used = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *parts]))  # (v,)
    numbers = np.zeros(old.n_vertices, dtype=np.int64)
    numbers[used] = np.arange(len(used))
    pairs = [pair.renumbered(numbers) for pair in old.pairs]
    surface = mode_points(robot.body.tetrahedra, Phi, points_at(used))
    return surface, ContactSet(pairs, len(used), old.alarm_distance, old.distance, old.sums)
