"""What the efforts of actuators add to the tangent of a body whose nodes have positions only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.actuators.chamber import ChamberSet, add_chamber_stiffness
from tauten.model.actuators.transmission import TransmissionSet
from tauten.model.numerics import Array, Ints
from tauten.model.points import (
    MeanPoints,
    NodeMotion,
    NodePoints,
    Paths,
    add_cable_stiffness,
    segment_nodes,
    segment_weights,
)
from tauten.model.system import Pattern


@dataclass(frozen=True, slots=True)
class Loads:
    """Efforts of all single actuators but drives.

    Attributes:
        tension: (cables,) [N].
        pressure: (chambers,) [Pa]; zero where only the positive semidefinite part is wanted.
        push: (forces,) [N].
        transmitted: (transmissions,); zero where only the positive semidefinite part is wanted.
    """

    tension: Array
    pressure: Array
    push: Array
    transmitted: Array


@dataclass(frozen=True, slots=True)
class NodalCurvature:
    """Second derivatives of lengths, volumes and functions, in the sparsity pattern of the nodes.

    Attributes:
        paths: of the cables.
        stations: points that they pass.
        weights: (s, 8) of the nodes of both ends of every segment, negative for the first end.
        chambers: cavities under pressure.
        cable_blocks: places of the segments in the pattern, see `Pattern.blocks`.
        chamber_blocks: places of the triangles of chambers.
        transmissions: functions of points; None: there are none.
        pattern: of the nodes.
    """

    paths: Paths
    stations: NodePoints
    weights: Array
    chambers: ChamberSet
    cable_blocks: tuple[Ints, Ints]
    chamber_blocks: tuple[Ints, Ints]
    transmissions: TransmissionSet[NodePoints | MeanPoints] | None
    pattern: Pattern

    def add(self, x: Array, loads: Loads, K: Array) -> None:
        """Add the curvature of cables, chambers and transmissions to a tangent.

        Args:
            x: (n_nodes, 3) node positions [m].
            loads: efforts.
            K: (nnz,) CSC values of −∂force, added to.
        """
        segments, y = self.paths.segment_arrays, self.stations.at(x)
        add_cable_stiffness(y, segments, self.weights, loads.tension, self.cable_blocks, K)
        if loads.pressure.any():
            surface = (self.chambers.nodes, self.chambers.weights)
            owner, blocks = self.chambers.owner, self.chamber_blocks
            add_chamber_stiffness(x, owner, surface, loads.pressure, blocks, K)
        if self.transmissions is not None:
            motion = NodeMotion(x, self.pattern.dof, self.pattern.n)
            self.transmissions.add_stiffness(motion, loads.transmitted, self.pattern, K)


def coupled_nodes(paths: Paths, stations: NodePoints, chambers: ChamberSet) -> list[Ints]:
    """Groups of nodes (g, s) that cables and chambers couple."""
    return [segment_nodes(paths, stations), chambers.nodes]


def nodal_curvature(
    paths: Paths,
    stations: NodePoints,
    chambers: ChamberSet,
    transmissions: TransmissionSet[NodePoints | MeanPoints] | None,
    pattern: Pattern,
) -> NodalCurvature:
    """The curvature of cables, chambers and transmissions in a pattern."""
    cables, surfaces = coupled_nodes(paths, stations, chambers)
    blocks = pattern.blocks(cables), pattern.blocks(surfaces)
    weights = np.ascontiguousarray(segment_weights(paths, stations))
    return NodalCurvature(paths, stations, weights, chambers, *blocks, transmissions, pattern)
