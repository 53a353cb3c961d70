"""Beams and springs of a robot in reduced coordinates: nodes of beams keep their positions and rotations."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from tauten.model.constraints import FrameJoints
from tauten.model.numerics import Array, Bools, Ints, kernel
from tauten.reduction.state.tetra.node_chart import NodeChart
from tauten.reduction.state.tetra.own_motion import Derivative, OwnMotion

ROUNDING = 1e-12  # of E, whose entries are of the order of one


@dataclass(frozen=True, slots=True, eq=False)
class ReducedSprings:
    """Springs between points of a body in reduced coordinates, energy ½ βᵀ K β + pᵀ β.

    Attributes:
        K: (R, R) [N/m].
        p: (R,) [N].
    """

    K: Array
    p: Array


@dataclass(frozen=True, slots=True, eq=False)
class ReducedBeams:
    """Beams whose nodes are at x₀ + E β, with the rotations of frames or drives.

    Attributes:
        joints: the elements, between the b nodes of beams alone.
        rest: (3 b,) positions of the nodes at rest [m].
        places: (3 b, R) E.
        turns: (3 b, n) angular velocities of the nodes by those of the coordinates.
        turning: (b,) the frame, then drive, that each node turns with, −1 where it is fixed.
        axes: (m, 3) of the drives; zero where these slide.
        entries: rows and columns of the elements' tangents, −1 where a node is fixed.
        inertia: (n, n) mass matrix of the rotary inertia [kg m²].
        floating: (n, n) the same of nodes that nothing holds.
        steady: (6 b, n) velocities of the nodes, then angular ones; None: they change with the state.
    """

    joints: FrameJoints
    rest: Array
    places: sp.csr_array
    turns: sp.csr_array
    turning: Ints
    axes: Array
    entries: tuple[Ints, Ints]
    inertia: Array
    floating: Array
    steady: sp.csr_array | None

    def rotations(self, motion: OwnMotion, q: Array) -> Array:
        """Rotations of the nodes at coordinates q (n,): (b, 4), unit quaternions."""
        theta = q[motion.modes : motion.modes + motion.drives]
        turns = np.concatenate(
            [q[motion.straight :].reshape(-1, 3), theta[:, None] * self.axes, np.zeros((1, 3))]
        )
        found: Array = Rotation.from_rotvec(turns).as_quat()[:, [3, 0, 1, 2]][self.turning]
        return found

    def forces(self, motion: OwnMotion, q: Array, beta: Array) -> tuple[float, Array, Array]:
        """Energy [J], forces for β (R,) [N], and moments for the rotations among the coordinates (n,) [N m].

        Args:
            motion: β of the coordinates.
            q: (n,) coordinates.
            beta: (R,) there.
        """
        x = (self.rest + self.places @ beta).reshape(-1, 3)
        energy, force, moment, _ = self.joints.assemble(x, self.rotations(motion, q), False)
        return energy, self.places.T @ force.ravel(), self.turns.T @ moment.ravel()

    def tangent(
        self, motion: OwnMotion, q: Array, beta: Array, J: Derivative, shares: tuple[float, float]
    ) -> Array:
        """A sum of the semidefinite and the exact tangent (n, n), without what turning levers add.

        Args:
            motion: β of the coordinates.
            q: (n,) coordinates.
            beta: (R,) there.
            J: derivative of β there.
            shares: of the semidefinite tangent and of the exact one.
        """
        x, Q = (self.rest + self.places @ beta).reshape(-1, 3), self.rotations(motion, q)
        values = np.zeros(len(self.entries[0]))
        for share, exact in zip(shares, (False, True), strict=True):
            if share > 0.0:
                values += share * self.joints.assemble(x, Q, exact)[3]
        T = self.steady
        if T is None:
            at = sp.csr_array(J.rows(self.places.toarray()))
            T = sp.csr_array(sp.vstack([at, self.turns]))
        tangent = np.zeros((J.n, J.n))
        add_products(*self.entries, values, T.indptr, T.indices, T.data, tangent)
        return tangent


@kernel
def add_products(
    rows: Ints, columns: Ints, values: Array, starts: Ints, places: Ints, T: Array, tangent: Array
) -> None:
    """Add Tᵀ K T to a tangent.

    Args:
        rows: (e,) of the entries of K, −1 where they are left out.
        columns: (e,) of the entries of K.
        values: (e,) of the entries of K.
        starts: row starts of T (6 b, n).
        places: its columns.
        T: its values.
        tangent: (n, n) added to.
    """
    for e in range(rows.shape[0]):
        i, j = rows[e], columns[e]
        if i < 0 or values[e] == 0.0:
            continue
        for p in range(starts[i], starts[i + 1]):
            for q in range(starts[j], starts[j + 1]):
                tangent[places[p], places[q]] += values[e] * T[p] * T[q]


def reduced_beams(
    chart: NodeChart, joints: FrameJoints, E: Array, motion: OwnMotion, floating: Bools
) -> ReducedBeams | None:
    """The beams of a robot in reduced coordinates; None: it has none.

    Args:
        chart: of the robot, which has frames.
        joints: its beams.
        E: (3 n_nodes, R) from `NodeChart.places`.
        motion: β of the coordinates.
        floating: (3 n_nodes,) which displacements nothing holds.
    """
    b, frames = len(joints.nodes), chart.frames
    if b == 0 or frames is None:
        return None
    dof = chart.tetrahedra.dof[joints.nodes]
    rows = np.where(dof >= 0, dof, 0)[:, None] + np.arange(3)
    places = np.where((dof >= 0)[:, None, None], E[rows], 0.0).reshape(3 * b, -1)
    drive = joints.turning - frames.n_turning
    by_drive = (joints.turning >= 0) & (drive >= 0)
    turning = np.maximum(joints.turning, 0)
    turning = np.where(by_drive, motion.frames + drive, turning)
    axes = np.where(frames.turns[:, None], frames.axes, 0.0)
    turns = np.zeros((b, 3, motion.n))
    for node, place in enumerate(turning):
        if joints.turning[node] < 0:
            continue
        if by_drive[node]:
            turns[node, :, motion.modes + drive[node]] = axes[drive[node]]
        else:
            first = motion.straight + 3 * place
            turns[node, :, first : first + 3] = np.eye(3)
    local = replace(joints, nodes=np.arange(b), springs=sp.csr_array((0, 3 * b)))
    spins, inertia = turns.reshape(3 * b, -1), np.repeat(joints.inertia, 3)[:, None]
    loose = ((dof >= 0) & floating[rows[:, 0]]).repeat(3)[:, None]
    places[np.abs(places) < ROUNDING] = 0.0
    J, steady = motion.jacobian(np.zeros(motion.size)), None
    changing = np.zeros(motion.size)
    changing[motion.modes + motion.turning] = changing[motion.straight :] = 1.0
    order = slice(None) if motion.order is None else motion.order
    if not places[:, changing[order] > 0.0].any():
        steady = sp.csr_array(np.vstack([J.rows(places), spins]))
    return ReducedBeams(
        joints=local,
        rest=chart.tetrahedra.mesh.nodes[joints.nodes].ravel(),
        places=sp.csr_array(places),
        turns=sp.csr_array(spins),
        turning=np.where(joints.turning < 0, -1, turning),
        axes=axes,
        entries=local.entries(np.arange(b)),
        inertia=spins.T @ (inertia * spins),
        floating=spins.T @ (loose * inertia * spins),
        steady=steady,
    )
