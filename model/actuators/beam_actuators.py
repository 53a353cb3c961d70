"""The actuators of a robot made of beams: cables and their couplings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.actuators.coupling import Coupling, motor_rows
from tauten.model.numerics import Array, Ints
from tauten.model.points import BeamCables, add_beam_cable_stiffness
from tauten.model.rows import Rows


@dataclass(frozen=True, slots=True)
class BeamActuators:
    """The actuators of a robot made of beams.

    Attributes:
        cables: tendons.
        coupling: of these; None: each is driven alone.
        cable_slot: places of the cables' curvature in the pattern.
    """

    cables: BeamCables
    coupling: Coupling | None
    cable_slot: tuple[Ints, Ints]

    @property
    def segment_owners(self) -> Ints:
        """The actuator of every segment of a cable: (s,)."""
        owners = self.cables.paths.owner
        return owners if self.coupling is None else self.coupling.motors_of(owners)

    def rows(self, x: Array, Q: Array, dof: Ints, n: int) -> Rows:
        """Positions δ_a and H_a: Rows of (n_a, n) [m].

        Args:
            x: (n_nodes, 3) node positions [m].
            Q: (n_nodes, 4) node rotations.
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        return motor_rows(self.coupling, self.member_rows(x, Q, dof, n))

    def member_rows(self, x: Array, Q: Array, dof: Ints, n: int) -> Rows:
        """Rows of the single cables: (members, n).

        Args:
            x: (n_nodes, 3) node positions [m].
            Q: (n_nodes, 4) node rotations.
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        return self.cables.paths.rows(self.cables.stations.placed(x, Q, dof, n))

    def preload(self, x: Array, Q: Array, dof: Ints, n: int) -> tuple[Array, float] | None:
        """Force (n,) [N, N m] of the offsets of couplings, and its work since rest [J]; None without any.

        Args:
            x: (n_nodes, 3) node positions [m].
            Q: (n_nodes, 4) node rotations.
            dof: (n_nodes,) first degree of freedom of a node, −1 where it is fixed.
            n: number of degrees of freedom.
        """
        if self.coupling is None or not self.coupling.is_preloaded:
            return None
        members = self.member_rows(x, Q, dof, n)
        return members.H.T @ self.coupling.offsets, float(self.coupling.offsets @ members.delta)

    def add_stiffness(self, x: Array, Q: Array, lam: Array | None, exact: bool, K: Array) -> None:
        """Add the curvature of the cables to a tangent.

        Args:
            x: (n_nodes, 3) node positions [m].
            Q: (n_nodes, 4) node rotations.
            lam: (n_a,) efforts [N]; None: of the offsets of couplings only.
            exact: with the rotation of lever arms, which may make the tangent indefinite.
            K: (nnz,) CSC values of −∂force, added to.
        """
        cables = self.cables
        if self.coupling is not None:
            motors = np.zeros(self.coupling.n_a) if lam is None else lam
            lam = self.coupling.efforts(motors)
        if lam is None:
            return
        points, arms = cables.stations.place(x, Q)
        add_beam_cable_stiffness(
            points, arms, cables.paths.segment_arrays, lam, exact, self.cable_slot, K
        )
