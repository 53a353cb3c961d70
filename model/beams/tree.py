"""Beams as a tree: elements that lead away from the fixed nodes, and their natural strains.

The natural strains of an element are (ε, φ) of `tauten.model.beams.elements`: stretch and shear times its
length, and relative rotation of its ends, six numbers that rigid motion does not change. Where one path leads
from the fixed nodes to every free one, they determine the configuration, and any values of them are possible:
they are coordinates of the robot, as the angles of a serial arm are.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from tauten.model.beams.beams import BeamError, Beams
from tauten.model.beams.elements import (
    BeamArrays,
    axis_change,
    offset_slopes,
    stretch_change,
    stretch_functions,
    stretched,
    turn_functions,
)
from tauten.model.numerics import (
    Array,
    Bools,
    add,
    conjugate,
    cross,
    dot,
    from_rotation_vector,
    kernel,
    product,
    quaternion,
    rotate,
    rotation_vector,
    row,
    subtract,
)

# Half a turn about axis 3: the axes of an element seen from its other end.
BACKWARDS = (0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class BeamTree:
    """Elements in an order in which each begins at a fixed node or where an earlier one ends.

    Attributes:
        beams: the elements, turned round where needed.
        D: (6 e,) stiffnesses of their natural strains [N/m], [N m].
    """

    beams: BeamArrays
    D: Array

    def __len__(self) -> int:
        return len(self.beams.length)

    def strains(self, x: Array, Q: Array) -> Array:
        """Natural strains (6 e,) [m], [rad] of nodes at x (n_nodes, 3) [m], turned by Q (n_nodes, 4)."""
        return natural_strains(x, Q, self.beams)

    def rates(self, x: Array, Q: Array, motion: Array) -> Array:
        """Rates of the natural strains: (6 e, k).

        Args:
            x: (n_nodes, 3) positions [m].
            Q: (n_nodes, 4) rotations, unit quaternions.
            motion: (n_nodes, 6, k) velocities and angular velocities of the nodes.
        """
        rates = np.empty((len(self) * 6, motion.shape[2]))
        for j in range(motion.shape[2]):
            rates[:, j] = strain_rates(x, Q, np.ascontiguousarray(motion[:, :, j]), self.beams)
        return rates


class BeamLoopError(BeamError):
    """Beams that do not branch from the fixed nodes."""


def make_tree(body: Beams, fixed: Bools) -> BeamTree:
    """The tree of a body's beams, of whose nodes some are fixed (n_nodes,).

    Raises:
        BeamLoopError: the beams form closed loops, fixed nodes included, or none of the nodes is fixed.
    """
    if not fixed.any():
        raise BeamLoopError("no node is fixed")
    touching: list[list[int]] = [[] for _ in body.nodes]
    for k, both in enumerate(body.ends):
        for end in both:
            touching[end].append(k)
    roots = np.flatnonzero(fixed)
    reached, order, ends = set(roots.tolist()), [], []
    waiting, used = deque(roots.tolist()), np.zeros(len(body.ends), dtype=bool)
    while waiting:
        node = waiting.popleft()
        for k in touching[node]:
            if used[k]:
                continue
            used[k] = True
            a, b = (int(end) for end in body.ends[k])
            other = b if node == a else a
            if other in reached:
                raise BeamLoopError(f"beams.{k} from node {a} to node {b} closes a loop")
            reached.add(other)
            waiting.append(other)
            order.append(k)
            ends.append((node, other))
    numbers = np.array(order, dtype=np.int64)
    turned_round = np.array(ends)[:, 0] != body.ends[numbers, 0]
    axes = body.axes[numbers].copy()
    for e in np.flatnonzero(turned_round):
        axes[e] = product(tuple(axes[e]), BACKWARDS)
    D = np.ascontiguousarray(body.D[numbers])
    beams = BeamArrays(np.array(ends, dtype=np.int64), axes, D, body.length[numbers].copy())
    return BeamTree(beams, D.ravel())


@kernel
def natural_strains(x: Array, Q: Array, beams: BeamArrays) -> Array:
    """Natural strains of all elements: (6 e,) [m], [rad].

    Args:
        x: (n_nodes, 3) positions [m].
        Q: (n_nodes, 4) rotations, unit quaternions.
        beams: the elements.
    """
    strains = np.empty(6 * beams.ends.shape[0])
    for k in range(beams.ends.shape[0]):
        _, phi, u = element_frame(x, Q, beams, k)
        gamma, eta, _, _, _, _ = stretch_functions(dot(phi, phi) ** 0.5)
        e = stretched(u, phi, gamma, eta)
        for i in range(3):
            strains[6 * k + i], strains[6 * k + 3 + i] = e[i], phi[i]
        slopes = offset_slopes(beams, k, e)
        strains[6 * k] += 0.5 * (slopes[0] * e[1] + slopes[1] * e[2]) - beams.length[k]
    return strains


@kernel
def element_frame(
    x: Array, Q: Array, beams: BeamArrays, k: int
) -> tuple[
    tuple[float, float, float, float], tuple[float, float, float], tuple[float, float, float]
]:
    """Frame, relative rotation φ and chord u of an element.

    Args:
        x: (n_nodes, 3) positions [m].
        Q: (n_nodes, 4) rotations, unit quaternions.
        beams: all elements.
        k: number of this one.
    """
    a, b, e = beams.ends[k, 0], beams.ends[k, 1], quaternion(beams.axes, k)
    first = product(quaternion(Q, a), e)
    phi = rotation_vector(product(conjugate(first), product(quaternion(Q, b), e)))
    half = from_rotation_vector((0.5 * phi[0], 0.5 * phi[1], 0.5 * phi[2]))
    frame = product(first, half)
    return frame, phi, rotate(conjugate(frame), subtract(row(x, b), row(x, a)))


@kernel
def strain_rates(x: Array, Q: Array, motion: Array, beams: BeamArrays) -> Array:
    """Rates of the natural strains, equation (B2) of `tauten.model.beams.elements`: (6 e,).

    Args:
        x: (n_nodes, 3) positions [m].
        Q: (n_nodes, 4) rotations, unit quaternions.
        motion: (n_nodes, 6) velocities and angular velocities of the nodes.
        beams: the elements.
    """
    rates = np.empty(6 * beams.ends.shape[0])
    for k in range(beams.ends.shape[0]):
        a, b = beams.ends[k]
        frame, phi, u = element_frame(x, Q, beams, k)
        theta = dot(phi, phi) ** 0.5
        gamma, eta, d_gamma, d_eta, _, _ = stretch_functions(theta)
        tau, _ = turn_functions(theta)
        back = conjugate(frame)
        dp = rotate(back, subtract(row(motion[:, :3], b), row(motion[:, :3], a)))
        da, db = rotate(back, row(motion[:, 3:], a)), rotate(back, row(motion[:, 3:], b))
        turn = subtract(db, da)
        across = cross(phi, turn)
        w0 = 0.5 * (da[0] + db[0]) - 0.5 * tau * across[0]
        w1 = 0.5 * (da[1] + db[1]) - 0.5 * tau * across[1]
        w2 = 0.5 * (da[2] + db[2]) - 0.5 * tau * across[2]
        du, dphi = add(dp, cross(u, (w0, w1, w2))), stretched(turn, phi, gamma, eta)
        de = add(stretched(du, phi, gamma, eta), stretch_change(u, phi, dphi, eta, d_gamma, d_eta))
        changed = axis_change(de, offset_slopes(beams, k, stretched(u, phi, gamma, eta)))
        for i in range(3):
            rates[6 * k + i], rates[6 * k + 3 + i] = changed[i], dphi[i]
    return rates
