"""The actuators of a robot in reduced coordinates, and their curvature.

The volume of a chamber is a cubic polynomial of the positions of its surface, hence of α: with β = (1, α)

    V = 1/6 T βββ,   ∂²V/∂α² = T β                                                          (T9)

without the first components of the derivative. The symmetric tensor T is summed over the surface once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.actuators import ActuatorSet
from tauten.model.numerics import Array
from tauten.model.tetra import TetBody
from tauten.reduction.state.tetra.arrays import Tendons
from tauten.reduction.state.tetra.body import ModePoints, mode_points, reduced_tendons
from tauten.reduction.state.tetra.points import node_rows

TRIANGLES = 128  # summed at a time


@dataclass(frozen=True, slots=True, eq=False)
class Wound:
    """The cables on drums at a state, see `tauten.model.constraints.Drums`.

    Attributes:
        H: (c, n) change of their pulled lengths, less that of what the drums have wound.
        tension: (c,) [N].
        tangent: (n, n) of the springs.
    """

    H: Array
    tension: Array
    tangent: Array


@dataclass(frozen=True, slots=True, eq=False)
class ModalCurvature:
    """Second derivatives of lengths and volumes in reduced coordinates.

    Attributes:
        tendons: segments of the cables.
        volumes: (c, r + 1, r + 1, r + 1) T of each chamber [m³].
    """

    tendons: Tendons
    volumes: Array

    def write(self, alpha: Array, pressure: Array, curvature: Array) -> None:
        """Write what the chambers add to the tangent, −Σ λ ∂²V/∂α².

        Args:
            alpha: (r,) state [m].
            pressure: (c,) [Pa].
            curvature: (r, r) to be overwritten; left alone without chambers.
        """
        for chamber, T in enumerate(self.volumes):
            part = contracted(T, alpha)[1:, 1:]
            if chamber == 0:
                np.multiply(part, -pressure[0], out=curvature)
            else:
                curvature -= pressure[chamber] * part


def contracted(T: Array, alpha: Array) -> Array:
    """T β (r + 1, r + 1) of (T9)."""
    size = len(T)
    product: Array = T.reshape(size * size, size) @ np.append(1.0, alpha)
    return product.reshape(size, size)


def reduced_actuators(body: TetBody, Phi: Array) -> ActuatorSet[ModePoints]:
    """The actuators of a body in the coordinates of a state basis Φ (n, r)."""
    full, tetrahedra = body.actuator_set, body.tetrahedra
    moved = full.transmissions
    return ActuatorSet(
        paths=full.paths,
        stations=mode_points(tetrahedra, Phi, full.stations),
        chambers=full.chambers,
        walls=mode_points(tetrahedra, Phi, full.walls),
        forces=full.forces,
        pushed=mode_points(tetrahedra, Phi, full.pushed),
        drives=full.drives,
        coupling=full.coupling,
        transmissions=None
        if moved is None
        else moved.over(mode_points(tetrahedra, Phi, moved.points)),
    )


def modal_curvature(body: TetBody, Phi: Array) -> ModalCurvature:
    """The curvature of the actuators in the coordinates of a state basis Φ (n, r)."""
    r, chambers = Phi.shape[1], body.actuator_set.chambers
    volumes = [volume_tensor(body, Phi, chamber) for chamber in range(len(chambers))]
    tendons = reduced_tendons(body.tetrahedra, Phi)
    return ModalCurvature(tendons, np.array(volumes).reshape(-1, r + 1, r + 1, r + 1))


def volume_tensor(body: TetBody, Phi: Array, chamber: int) -> Array:
    """T (r + 1, r + 1, r + 1) of (T9).

    Args:
        body: of the full model.
        Phi: (n, r) state modes.
        chamber: its number.
    """
    chambers = body.actuator_set.chambers
    chosen = np.flatnonzero(chambers.owner == chamber)
    size = Phi.shape[1] + 1
    T = np.zeros((size, size, size))
    every = node_rows(body.tetrahedra, Phi, np.arange(body.n_nodes))  # (n_nodes, 3, r)
    columns_of = np.concatenate([body.mesh.nodes[..., None], every], axis=2)
    corners = chambers.corners(columns_of, chosen)  # (t, 3, 3, r + 1)
    corners[..., 0] -= corners[..., 0].mean(axis=(0, 1))  # a volume does not depend on it
    for columns in np.array_split(corners, len(chosen) // TRIANGLES + 1):
        a, b, c = (columns[:, corner] for corner in range(3))  # (t, 3, r + 1)
        area = np.cross(b[:, :, :, None], c[:, :, None, :], axis=1)  # (t, 3, r + 1, r + 1)
        flat = a.reshape(-1, size).T @ area.reshape(-1, size * size)
        T += flat.reshape(size, size, size) / 6.0
    orders = ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0))
    return np.ascontiguousarray(sum(np.transpose(T, order) for order in orders))
