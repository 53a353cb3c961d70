"""The actuators of a robot in reduced coordinates: cables, chambers, forces, and their couplings.

The volume of a chamber is a cubic polynomial of the positions of its surface, hence of α: with β = (1, α)

    V = 1/6 T βββ,   ∂V/∂α = 1/2 (T ββ),   ∂²V/∂α² = T β                                     (T5)

without the first components of the derivatives. The symmetric tensor T is summed over the surface once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model import Rows
from tauten.model.actuators import Coupling, motor_rows
from tauten.model.numerics import Array
from tauten.model.points import Paths
from tauten.model.tetra import TetRobot
from tauten.reduction.state.tetra.arrays import Tendons
from tauten.reduction.state.tetra.body import ReducedPoints, reduced_stations, reduced_tendons
from tauten.reduction.state.tetra.points import node_rows

TRIANGLES = 128  # summed at a time


@dataclass(frozen=True, slots=True, eq=False)
class ReducedActuators:
    """The actuators of a reduced robot.

    Attributes:
        paths: of the cables.
        stations: points that they pass.
        tendons: their segments, for the curvature.
        volumes: (c, r + 1, r + 1, r + 1) T of each chamber [m³].
        forces: (f, r) constant rows of the forces.
        coupling: of all of these; None: each is driven alone.
    """

    paths: Paths
    stations: ReducedPoints
    tendons: Tendons
    volumes: Array
    forces: Array
    coupling: Coupling | None

    @property
    def n_a(self) -> int:
        """Number of motors, the length of λ_a."""
        if self.coupling is not None:
            return self.coupling.n_a
        return self.paths.n_a + len(self.volumes) + len(self.forces)

    def rows(self, alpha: Array) -> Rows:
        """Positions δ_a and H_a at a state α (r,): Rows of (n_a, r)."""
        return motor_rows(self.coupling, self._member_rows(alpha))

    def efforts(self, lam: Array) -> Array:
        """Efforts on the single actuators under efforts of the motors lam (n_a,)."""
        return lam if self.coupling is None else self.coupling.efforts(lam)

    def tensions(self, efforts: Array) -> Array:
        """Those of the cables among the efforts of the single actuators."""
        return efforts[: self.paths.n_a]

    def preload(self, alpha: Array) -> Array | None:
        """Force (r,) [N] of the offsets of couplings at a state α (r,); None without any."""
        if self.coupling is None or not self.coupling.is_preloaded:
            return None
        force: Array = self.coupling.offsets @ self._member_rows(alpha).H
        return force

    def set_curvature(self, alpha: Array, efforts: Array, curvature: Array) -> None:
        """Write what the chambers add to the tangent, −Σ λ ∂²V/∂α².

        Args:
            alpha: (r,) state [m].
            efforts: of the single actuators.
            curvature: (r, r) to be overwritten; left alone without chambers.
        """
        first = self.paths.n_a
        for chamber, T in enumerate(self.volumes):
            part = contracted(T, alpha)[1:, 1:]
            if chamber == 0:
                np.multiply(part, -efforts[first], out=curvature)
            else:
                curvature -= efforts[first + chamber] * part

    def _member_rows(self, alpha: Array) -> Rows:
        cables = self.paths.rows(self.stations.placed(alpha))
        if len(self.volumes) + len(self.forces) == 0:
            return cables
        slopes, values = [cables.dense()], [cables.delta]
        beta = np.append(1.0, alpha)
        for T in self.volumes:
            slope = 0.5 * (contracted(T, alpha) @ beta)  # (r + 1,)
            slopes.append(slope[None, 1:])
            values.append(np.array([(slope @ beta) / 3.0 - T[0, 0, 0] / 6.0]))
        slopes.append(self.forces)
        values.append(self.forces @ alpha)
        return Rows(np.vstack(slopes), np.concatenate(values))


def contracted(T: Array, alpha: Array) -> Array:
    """T β (r + 1, r + 1) of (T5)."""
    size = len(T)
    product: Array = T.reshape(size * size, size) @ np.append(1.0, alpha)
    return product.reshape(size, size)


def reduced_actuators(robot: TetRobot, Phi: Array) -> ReducedActuators:
    """The actuators of a robot in the coordinates of a state basis Φ (n, r)."""
    full, r = robot.actuator_set, Phi.shape[1]
    volumes = [volume_tensor(robot, Phi, chamber) for chamber in range(len(full.chambers))]
    return ReducedActuators(
        paths=full.cables.paths,
        stations=reduced_stations(robot, Phi),
        tendons=reduced_tendons(robot, Phi),
        volumes=np.array(volumes).reshape(-1, r + 1, r + 1, r + 1),
        forces=np.asarray(full.forces.H @ Phi),
        coupling=full.coupling,
    )


def volume_tensor(robot: TetRobot, Phi: Array, chamber: int) -> Array:
    """T (r + 1, r + 1, r + 1) of (T5).

    Args:
        robot: the full model.
        Phi: (n, r) state modes.
        chamber: its number.
    """
    chambers = robot.actuator_set.chambers
    chosen = np.flatnonzero(chambers.owner == chamber)
    size = Phi.shape[1] + 1
    T = np.zeros((size, size, size))
    every = node_rows(robot, Phi, np.arange(robot.n_nodes))  # (n_nodes, 3, r)
    columns_of = np.concatenate([robot.mesh.nodes[..., None], every], axis=2)
    corners = chambers.corners(columns_of, chosen)  # (t, 3, 3, r + 1)
    corners[..., 0] -= corners[..., 0].mean(axis=(0, 1))  # a volume does not depend on it
    for columns in np.array_split(corners, len(chosen) // TRIANGLES + 1):
        a, b, c = (columns[:, corner] for corner in range(3))  # (t, 3, r + 1)
        area = np.cross(b[:, :, :, None], c[:, :, None, :], axis=1)  # (t, 3, r + 1, r + 1)
        flat = a.reshape(-1, size).T @ area.reshape(-1, size * size)
        T += flat.reshape(size, size, size) / 6.0
    orders = ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0))
    return np.ascontiguousarray(sum(np.transpose(T, order) for order in orders))
