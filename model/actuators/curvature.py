"""What the efforts of actuators add to the tangent of a body whose nodes have positions only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.actuators.actuator_set import ActuatorSet, Loads
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


def coupled_nodes(actuators: ActuatorSet[NodePoints | MeanPoints]) -> list[Ints]:
    """Groups of nodes (g, s) that cables, chambers and transmissions couple, in this order."""
    stations, moved = actuators.stations, actuators.transmissions
    assert isinstance(stations, NodePoints)  # cables pass combinations of a few nodes each
    found = [segment_nodes(actuators.paths, stations), actuators.chambers.nodes]
    if moved is not None:
        assert isinstance(moved.points, NodePoints)
        found += moved.coupled(moved.points.nodes)
    return found


def nodal_curvature(
    actuators: ActuatorSet[NodePoints | MeanPoints], pattern: Pattern
) -> NodalCurvature:
    """The curvature of cables, chambers and transmissions in a pattern."""
    paths, stations, chambers = actuators.paths, actuators.stations, actuators.chambers
    assert isinstance(stations, NodePoints)
    blocks = pattern.blocks(segment_nodes(paths, stations)), pattern.blocks(chambers.nodes)
    weights = np.ascontiguousarray(segment_weights(paths, stations))
    moved = actuators.transmissions
    return NodalCurvature(paths, stations, weights, chambers, *blocks, moved, pattern)
