"""What the efforts of actuators add to the tangent of a body whose nodes have positions only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.actuators.actuator_set import ActuatorSet, Loads
from tauten.model.actuators.chamber import add_chamber_stiffness
from tauten.model.numerics import Array, Ints
from tauten.model.points import (
    MeanPoints,
    NodeMotion,
    NodePoints,
    add_cable_stiffness,
    segment_nodes,
    segment_weights,
)
from tauten.model.system import Pattern


@dataclass(frozen=True, slots=True)
class NodalCurvature:
    """Second derivatives of lengths, volumes and functions, in the sparsity pattern of the nodes.

    Attributes:
        actuators: all but drives.
        ends: (s, 8) nodes of both ends of every segment of cables.
        weights: (s, 8) of these, negative for the first end.
        cable_blocks: places of the segments in the pattern, see `Pattern.blocks`.
        chamber_blocks: places of the triangles of chambers.
        pattern: of the nodes.
    """

    actuators: ActuatorSet[NodePoints | MeanPoints]
    ends: Ints
    weights: Array
    cable_blocks: tuple[Ints, Ints]
    chamber_blocks: tuple[Ints, Ints]
    pattern: Pattern

    def add(self, x: Array, loads: Loads, K: Array) -> None:
        """Add the curvature of cables, chambers and transmissions to a tangent.

        Args:
            x: (n_nodes, 3) node positions [m].
            loads: efforts.
            K: (nnz,) CSC values of −∂force, added to.
        """
        actuators = self.actuators
        chambers, moved = actuators.chambers, actuators.transmissions
        segments, y = actuators.paths.segment_arrays, actuators.stations.at(x)
        add_cable_stiffness(y, segments, self.weights, loads.tension, self.cable_blocks, K)
        if loads.pressure.any():
            surface, blocks = (chambers.nodes, chambers.weights), self.chamber_blocks
            add_chamber_stiffness(x, chambers.owner, surface, loads.pressure, blocks, K)
        if moved is not None:
            motion = NodeMotion(x, self.pattern.dof, self.pattern.n)
            moved.add_stiffness(motion, loads.transmitted, self.pattern, K)


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
    paths, stations = actuators.paths, actuators.stations
    assert isinstance(stations, NodePoints)
    ends = segment_nodes(paths, stations)
    blocks = pattern.blocks(ends), pattern.blocks(actuators.chambers.nodes)
    weights = np.ascontiguousarray(segment_weights(paths, stations))
    return NodalCurvature(actuators, ends, weights, *blocks, pattern)
