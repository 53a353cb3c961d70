"""Places on the bodies of a robot file: nodes that regions select, and points that are attached to bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from tauten.model.beams import Beams
from tauten.model.load.beam_bodies import CORNERS
from tauten.model.load.bodies import AT_DISC, Bodies
from tauten.model.load.joins import combination
from tauten.model.mesh import NodeSelector
from tauten.model.numerics import Array, Bools, Ints, joined
from tauten.model.points import (
    AttachedPoints,
    NodePoints,
    attach,
    attach_to_nodes,
    combinations,
    join_attached_points,
)
from tauten.model.schema import Extrapolation, Region, RobotFileError

Positions = Sequence[tuple[float, float, float]]
P = TypeVar("P")


class Places(NodeSelector, Protocol[P]):
    """Nodes and points of all bodies."""

    def attach(self, points: Positions, what: str, slack: float) -> P:
        """Points, each attached to the bodies.

        Args:
            points: positions at rest [m].
            what: the field they come from, for errors.
            slack: how far outside a point may lie [m].

        Raises:
            RobotFileError: a point lies further outside.
        """

    def at_nodes(self, ids: Ints) -> P:
        """Nodes (p,) as points."""

    def held(self, points: Positions) -> P:
        """Points (p, 3) that stay where they are [m]."""

    def join(self, parts: Sequence[P]) -> P:
        """All points one after the other."""

    def at_rest(self, points: P) -> Array:
        """Positions of points: (p, 3) [m]."""


@dataclass(frozen=True, slots=True)
class OnBodies:
    """What all places on bodies have."""

    bodies: Bodies

    @property
    def source(self) -> str:
        """The robot file, for errors."""
        return self.bodies.selector.source


@dataclass(frozen=True, slots=True)
class MeshPlaces(OnBodies):
    """Places on bodies in which points are combinations of nodes.

    Attributes, beside those of `OnBodies`:
        extrapolate_from: what points outside the mesh are moved by.
    """

    extrapolate_from: Extrapolation

    @property
    def nodes(self) -> Array:
        """Nodes at rest: (n_nodes, 3) [m]."""
        return self.bodies.parts.mesh.nodes

    def select_nodes(self, selection: Region | str, what: str) -> Bools:
        """Which nodes a region selects: (n_nodes,)."""
        return self.bodies.selector.select_nodes(selection, what)

    def attach(self, points: Positions, what: str, slack: float) -> NodePoints:
        """Points in the elements that contain them or are nearest, near a disc at its node, see `Places`."""
        mesh, places, discs = self.bodies.parts.mesh, np.array(points), {}
        for number, point in enumerate(places):
            disc = self.bodies.nearest_disc(point)
            if disc is not None and disc[0] <= max(slack, AT_DISC):
                discs[number] = disc[1]
        carriers = places.copy()
        carriers[list(discs)] = mesh.nodes[list(discs.values())]
        try:
            found = attach(
                mesh, carriers, what, slack, self.extrapolate_from, self.bodies.of_beams(mesh)
            )
        except ValueError as error:
            raise RobotFileError(str(error)) from error
        for number, node in discs.items():
            corners = node + np.arange(CORNERS)
            found.nodes[number] = corners
            found.weights[number] = combination(mesh.nodes[corners], places[number])
        return found

    def at_nodes(self, ids: Ints) -> NodePoints:
        """Nodes (p,) as points."""
        weights = np.tile([1.0, 0.0, 0.0, 0.0], (len(ids), 1))
        return combinations(np.repeat(ids[:, None], 4, axis=1), weights)

    def held(self, points: Positions) -> NodePoints:
        """Points (p, 3) that stay where they are [m]."""
        count = len(points)
        fixed = np.array(points, dtype=float).reshape(-1, 3)
        return NodePoints(np.zeros((count, 4), dtype=np.int64), np.zeros((count, 4)), fixed)

    def join(self, parts: Sequence[NodePoints]) -> NodePoints:
        """All points one after the other."""
        return joined([self.held([]), *parts])

    def at_rest(self, points: NodePoints) -> Array:
        """Positions of points: (p, 3) [m]."""
        return points.at(self.nodes)


@dataclass(frozen=True, slots=True)
class BeamPlaces(OnBodies):
    """Places on bodies that are all made of beams; points move with one node each.

    Attributes, beside those of `OnBodies`:
        beams: the beams as one.
        fixed: (b,) which of their nodes do not move.
    """

    beams: Beams
    fixed: Bools

    @property
    def nodes(self) -> Array:
        """Nodes of the beams at rest: (b, 3) [m]."""
        return self.beams.nodes

    def select_nodes(self, selection: Region | str, what: str) -> Bools:
        """Which of these nodes a region selects: (b,)."""
        return self.bodies.selector.select_nodes(selection, what)[self.bodies.beam_nodes]

    def attach(self, points: Positions, what: str, slack: float) -> AttachedPoints:
        """Points, each at the node of the nearest disc within `slack`, otherwise at the nearest node.

        Those within the radius of the cross-section are at the node. See `Places`.
        """
        ids, parts = [], self.bodies.beams
        radius = np.repeat([part.radius for part in parts], [len(part.nodes) for part in parts])
        for number, point in enumerate(np.array(points)):
            disc = self.bodies.nearest_disc(point)
            if disc is not None and disc[0] <= max(slack, AT_DISC):
                ids.append(int(np.searchsorted(self.bodies.beam_nodes, disc[1])))
                continue
            away = np.linalg.norm(self.nodes - point, axis=1)
            nearest = int(away.argmin())
            beyond = float(away[nearest] - radius[nearest])
            if beyond > max(slack, 1e-9 * self.beams.size):
                carrier = f"node at {self.nodes[nearest].round(6).tolist()} m"
                if disc is not None and disc[0] < beyond:
                    beyond, carrier = disc[0], f"disc {disc[2]!r}"
                raise RobotFileError(
                    f"{what}: point {number} at {point.tolist()} m lies {beyond:.3g} m outside of the "
                    f"nearest {carrier}, allowed is {slack:g} m: move it, or set max_outside"
                )
            ids.append(nearest)
        return attach_to_nodes(self.nodes, np.array(ids, dtype=np.int64), np.array(points))

    def at_nodes(self, ids: Ints) -> AttachedPoints:
        """Nodes (p,) as points."""
        return attach_to_nodes(self.nodes, ids, self.nodes[ids])

    def held(self, points: Positions) -> AttachedPoints:
        """Points (p, 3) that stay where they are, as a fixed node does [m]."""
        base = np.full(len(points), int(self.fixed.argmax()))
        return attach_to_nodes(self.nodes, base, np.array(points, dtype=float).reshape(-1, 3))

    def corners(self, ids: Ints) -> AttachedPoints:
        """Some nodes (m,), each with the three corners of its tetrahedron: (4 m,) points."""
        corners = self.bodies.beam_nodes[ids][:, None] + np.arange(CORNERS)
        places = self.bodies.parts.mesh.nodes[corners.ravel()]
        return attach_to_nodes(self.nodes, np.repeat(ids, CORNERS), places)

    def join(self, parts: Sequence[AttachedPoints]) -> AttachedPoints:
        """All points one after the other."""
        return join_attached_points(list(parts))

    def at_rest(self, points: AttachedPoints) -> Array:
        """Positions of points: (p, 3) [m]."""
        return points.at_rest(self.nodes)
