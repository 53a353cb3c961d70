"""The actuators of a robot made of tetrahedra: cables, chambers, forces, and their couplings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.actuators.chamber import (
    ChamberSet,
    ChamberSurface,
    add_chamber_stiffness,
    make_chambers,
)
from tauten.model.actuators.coupling import Coupling, motor_rows
from tauten.model.actuators.force import ForceSet, PointForce, make_forces
from tauten.model.numerics import Array, Ints
from tauten.model.points import CableSet, add_cable_stiffness
from tauten.model.rows import Rows, stack
from tauten.model.system import Pattern


@dataclass(frozen=True, slots=True)
class ActuatorParts:
    """The actuators of a body, before their places in the sparsity pattern are known.

    Attributes:
        cables: in the order of the robot file.
        chambers: closed surface of each.
        forces: in the order of the robot file.
        coupling: of these; None: there is none.
    """

    cables: CableSet
    chambers: list[ChamberSurface]
    forces: list[PointForce]
    coupling: Coupling | None = None

    @property
    def groups(self) -> list[Ints]:
        """Groups of nodes (g, s) that the actuators couple."""
        surfaces = [chamber.corners(chamber.corner_nodes)[0] for chamber in self.chambers]
        return [self.cables.segment_nodes, *surfaces]


@dataclass(frozen=True, slots=True)
class ActuatorSet:
    """The actuators of a robot made of tetrahedra.

    Attributes:
        cables: tendons.
        chambers: cavities under pressure.
        forces: of fixed direction.
        coupling: of all of these; None: each is driven alone.
        cable_slot: places of the cables' curvature in the pattern.
        chamber_slot: places of the chambers' curvature in the pattern.
    """

    cables: CableSet
    chambers: ChamberSet
    forces: ForceSet
    coupling: Coupling | None
    cable_slot: tuple[Ints, Ints]
    chamber_slot: tuple[Ints, Ints]

    @property
    def n_a(self) -> int:
        """Number of motors, the length of λ_a."""
        return self.n_members if self.coupling is None else self.coupling.n_a

    @property
    def n_members(self) -> int:
        """Number of single actuators."""
        return self.cables.n_a + len(self.chambers) + len(self.forces)

    @property
    def segment_members(self) -> Ints:
        """The single actuator of every segment that `segments` gives: (s,)."""
        first = self.cables.n_a + len(self.chambers)
        return np.concatenate([self.cables.paths.owner, first + np.arange(len(self.forces))])

    def segments(self, x: Array) -> Array:
        """Segments by which cables and forces are drawn: (s, 2, 3) [m].

        Args:
            x: (n_nodes, 3) node positions [m].
        """
        cables = self.cables.paths.segments(self.cables.stations(x))
        return np.concatenate([cables, self.forces.segments(x)])

    def chamber_members(self, triangles: Ints) -> Ints:
        """The single actuator whose chamber each of some triangles (t, 3) encloses; −1 where none: (t,)."""
        members = np.full(len(triangles), -1)
        number = {tuple(one): i for i, one in enumerate(np.sort(triangles, axis=1).tolist())}
        surface, owner = self.chambers.boundary_triangles()
        for corners, chamber in zip(np.sort(surface, axis=1).tolist(), owner, strict=True):
            if tuple(corners) in number:
                members[number[tuple(corners)]] = self.cables.n_a + chamber
        return members

    def motors(self, members: Ints) -> Ints:
        """The actuators (m,) that drive single actuators (m,); −1 remains −1."""
        return members if self.coupling is None else self.coupling.motors_of(members)

    def rows(self, x: Array, dof: Ints, n: int) -> Rows:
        """Positions δ_a and H_a: Rows of (n_a, n).

        Args:
            x: (n_nodes, 3) node positions [m].
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        return motor_rows(self.coupling, self.member_rows(x, dof, n))

    def member_rows(self, x: Array, dof: Ints, n: int) -> Rows:
        """Rows of the single actuators; arguments as for `rows`.

        Args:
            x: (n_nodes, 3) node positions [m].
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        cables = self.cables.paths.rows(self.cables.placed(x, dof, n))
        if self.n_members == len(cables):
            return cables
        parts = [cables]
        if len(self.chambers) > 0:
            parts.append(self.chambers.rows(self.chambers.placed(x, dof, n)))
        if len(self.forces) > 0:
            parts.append(self.forces.rows(x[dof >= 0].ravel()))
        return stack(parts)

    def preload(self, x: Array, dof: Ints, n: int) -> tuple[Array, float] | None:
        """Force (n,) [N] of the offsets of couplings, and its work since rest [J]; None without any.

        Args:
            x: (n_nodes, 3) node positions [m].
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        if self.coupling is None or not self.coupling.is_preloaded:
            return None
        members, offsets = self.member_rows(x, dof, n), self.coupling.offsets
        return members.H.T @ offsets, float(offsets @ members.delta)

    def add_stiffness(self, x: Array, lam: Array | None, exact: bool, K: Array) -> None:
        """Add the curvature of the actuators to a tangent.

        Args:
            x: (n_nodes, 3) node positions [m].
            lam: (n_a,) efforts; None: of the offsets of couplings only.
            exact: whether terms that are not positive semidefinite are added, those of chambers and of rods
                that push.
            K: (nnz,) CSC values of −∂force, added to.
        """
        if self.coupling is not None:
            lam = self.coupling.efforts(np.zeros(self.n_a) if lam is None else lam)
        if lam is None:
            return
        c, n_cables = self.cables, self.cables.n_a
        effort = lam[:n_cables] if exact else np.maximum(lam[:n_cables], 0.0)
        segments, weights = c.paths.segment_arrays, c.segment_weights
        add_cable_stiffness(c.stations(x), segments, weights, effort, self.cable_slot, K)
        if exact and len(self.chambers) > 0:
            pressure = lam[n_cables : n_cables + len(self.chambers)]
            surface = (self.chambers.nodes, self.chambers.weights)
            add_chamber_stiffness(x, self.chambers.owner, surface, pressure, self.chamber_slot, K)


def place_actuators(parts: ActuatorParts, x0: Array, pattern: Pattern) -> ActuatorSet:
    """The actuators in a sparsity pattern.

    Args:
        parts: the actuators.
        x0: (n_nodes, 3) node positions at rest [m].
        pattern: in which their `groups` are coupled.
    """
    chambers = make_chambers(parts.chambers, x0)
    return ActuatorSet(
        cables=parts.cables,
        chambers=chambers,
        forces=make_forces(parts.forces, x0, pattern.dof, pattern.n),
        coupling=parts.coupling,
        cable_slot=pattern.blocks(parts.cables.segment_nodes),
        chamber_slot=pattern.blocks(chambers.nodes),
    )
