"""The QP for a change of the efforts, with contact forces that follow them in the first order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tauten.controller.friction.dual_qp import solve_dual
from tauten.controller.friction.problem import RANK, FrictionInverse, contact_rows, symmetric_root
from tauten.controller.qpcc import UNBOUNDED
from tauten.model.numerics import Array, Ints, kernel

PULL = 100.0  # weight of violated limits against the objective, by their curvatures
BEYOND = 1e-9  # of the largest row value, violation of a limit that is pulled back


class EffortArrays(NamedTuple):
    """Objective and limits of an inverse problem, on the rows of its contacts with three rows each.

    Attributes:
        root_a: (k, n_a) columns of the efforts of F with Q = Fᵀ F.
        root_c: (k, 3 m) those of the contact forces.
        c_a: (n_a,) linear term.
        c_c: (3 m,) linear term.
        lb: (n_a,) limits of the efforts.
        ub: (n_a,) limits of the efforts.
        G_a: (p, n_a) rows of the limits.
        G_c: (p, 3 m) rows of the limits.
        g_lo: (p,) limits of these.
        g_hi: (p,) limits of these.
        constant: of the objective.
    """

    root_a: Array
    root_c: Array
    c_a: Array
    c_c: Array
    lb: Array
    ub: Array
    G_a: Array
    G_c: Array
    g_lo: Array
    g_hi: Array
    constant: float


def effort_arrays(problem: FrictionInverse) -> EffortArrays:
    """The arrays of a problem; its Q is factorised."""
    p, place = problem.program, contact_rows(problem)
    size = len(p.m) + 2 * problem.singles
    root = objective_root(p.Q, problem.energy)
    given = (p.c, p.lb, p.ub, p.G, p.g_lo, p.g_hi)
    c, lb, ub, G, g_lo, g_hi = (np.ascontiguousarray(values, dtype=float) for values in given)
    parts = padded_arrays(root, c, G, place, size)
    return EffortArrays(*parts[:4], lb, ub, *parts[4:], g_lo, g_hi, p.constant)


def objective_root(Q: Array, energy: Array | None) -> Array:
    """G (n, k) with Q = G Gᵀ.

    The energy has columns of its own: beside the compliance of an object that nothing holds it is lost in
    rounding, and efforts that differ in their energy alone would be equal.

    Args:
        Q: (n, n) curvature of the objective.
        energy: (n_a, n_a) part of it in the efforts; None: nothing is known of it.
    """
    if energy is None:
        return symmetric_root(Q, -1.0)
    rest, n_a = Q.copy(), len(energy)
    rest[:n_a, :n_a] -= energy
    root = symmetric_root(rest, RANK * max(float(rest.diagonal().max()), 1e-300))
    own = symmetric_root(energy, -1.0)
    return np.hstack([root, np.vstack([own, np.zeros((len(Q) - n_a, own.shape[1]))])])


@kernel
def padded_arrays(
    root: Array, c: Array, G: Array, place: Ints, size: int
) -> tuple[Array, Array, Array, Array, Array, Array]:
    """`root_a`, `root_c`, `c_a`, `c_c`, `G_a` and `G_c` of a problem.

    Args:
        root: (n, k) factor of Q.
        c: (n,) linear term.
        G: (p, n) rows of the limits.
        place: (s + 3 k,) where each contact row of the problem is.
        size: number of contact rows.
    """
    n_a = len(c) - len(place)
    root_c, c_c, G_c = np.zeros((root.shape[1], size)), np.zeros(size), np.zeros((len(G), size))
    for i, row in enumerate(place):
        root_c[:, row], c_c[row], G_c[:, row] = root[n_a + i], c[n_a + i], G[:, n_a + i]
    return root[:n_a].T.copy(), root_c, c[:n_a].copy(), c_c, G[:, :n_a].copy(), G_c


class EffortQp(NamedTuple):
    """A QP (5) in variables of order one, and the way back from its solution.

    Attributes:
        H: (n_a, n_a).
        f: (n_a,).
        A: (p, n_a).
        lower: (n_a + p,).
        upper: (n_a + p,).
        unit: (n_a,) change of each effort by a variable of one.
        curvature: (n_a, n_a) of the objective.
        gradient: (n_a,) of the objective.
    """

    H: Array
    f: Array
    A: Array
    lower: Array
    upper: Array
    unit: Array
    curvature: Array
    gradient: Array


@kernel
def effort_qp(arrays: EffortArrays, lam: Array, r: Array, slope: Array, trust: Array) -> EffortQp:
    """The QP for a change of the efforts.

    Limits contain the present point: a violated one does not become worse, and pulls.

    Args:
        arrays: objective and limits.
        lam: (n_a,) efforts.
        r: (3 m,) contact forces there, or where the law of contact leads from them.
        slope: (3 m, n_a) of the forces.
        trust: (n_a,) largest change of each effort.
    """
    n_a, p = len(lam), len(arrays.g_lo)
    T = arrays.root_a + np.dot(arrays.root_c, slope)
    at = np.dot(arrays.root_a, lam) + np.dot(arrays.root_c, r)
    H = np.dot(T.T, T)
    f = np.dot(T.T, at) + arrays.c_a + np.dot(slope.T, arrays.c_c)
    A = arrays.G_a + np.dot(arrays.G_c, slope)
    rows = np.dot(arrays.G_a, lam) + np.dot(arrays.G_c, r)
    lo, hi = arrays.g_lo - rows, arrays.g_hi - rows
    H_all, f_all = with_pull(H, f, A, lo, hi, BEYOND * np.abs(rows).max() if p > 0 else 0.0)
    unit, cost = np.empty(n_a), 1e-300
    for j in range(n_a):
        unit[j] = 1.0 / np.sqrt(max(H_all[j, j], 1e-300))
        cost = max(cost, abs(f_all[j]) * unit[j])
    lower, upper = np.empty(n_a + p), np.empty(n_a + p)
    for j in range(n_a):
        lower[j] = min(max(arrays.lb[j] - lam[j], -trust[j]), 0.0) / unit[j] / cost
        upper[j] = max(min(arrays.ub[j] - lam[j], trust[j]), 0.0) / unit[j] / cost
        f_all[j] *= unit[j] / cost
        for i in range(n_a):
            H_all[i, j] *= unit[j]
            H_all[j, i] *= unit[j]
        for i in range(p):
            A[i, j] *= unit[j]
    for i in range(p):
        lower[n_a + i] = min(lo[i], 0.0) / cost
        upper[n_a + i] = max(hi[i], 0.0) / cost
    lower, upper = np.maximum(lower, -UNBOUNDED), np.minimum(upper, UNBOUNDED)
    return EffortQp(H_all, f_all, A, lower, upper, cost * unit, H, f)


@kernel
def with_pull(
    H: Array, f: Array, A: Array, lo: Array, hi: Array, margin: float
) -> tuple[Array, Array]:
    """H (n_a, n_a) and f (n_a,) with the square of what limits are exceeded by.

    Args:
        H: (n_a, n_a) curvature of the objective.
        f: (n_a,) its gradient.
        A: (p, n_a) rows of the limits.
        lo: (p,) least change of the rows.
        hi: (p,) largest change of the rows.
        margin: that does not count as exceeded.
    """
    H_all, f_all, total = H.copy(), f.copy(), 0.0
    for i in range(len(lo)):
        if lo[i] > margin or hi[i] < -margin:
            total += np.dot(A[i], A[i])
    if total > 0.0:
        weight = PULL * np.trace(H) / max(total, 1e-300)
        for i in range(len(lo)):
            if lo[i] > margin or hi[i] < -margin:
                gap = lo[i] if lo[i] > margin else hi[i]
                H_all += weight * np.outer(A[i], A[i])
                f_all -= weight * gap * A[i]
    return H_all, f_all


@kernel
def effort_change(qp: EffortQp, y: Array) -> tuple[Array, float]:
    """The change of the efforts (n_a,) by variables y (n_a,), and by how much the objective falls.

    Args:
        qp: the QP.
        y: (n_a,) its solution.
    """
    n_a = len(y)
    change = np.minimum(np.maximum(y, qp.lower[:n_a]), qp.upper[:n_a]) * qp.unit
    gain = -(np.dot(qp.gradient, change) + 0.5 * np.dot(change, np.dot(qp.curvature, change)))
    return change, gain


@kernel
def effort_step(
    arrays: EffortArrays, lam: Array, r: Array, slope: Array, trust: Array
) -> tuple[bool, Array, float]:
    """Whether the QP was solved, the change of the efforts (n_a,), and by how much the objective falls.

    Args:
        arrays: objective and limits.
        lam: (n_a,) efforts.
        r: (3 m,) contact forces there, or where the law of contact leads from them.
        slope: (3 m, n_a) of the forces.
        trust: (n_a,) largest change of each effort.
    """
    qp = effort_qp(arrays, lam, r, slope, trust)
    solved, y = solve_dual(qp.H, qp.f, qp.A, qp.lower, qp.upper)
    change, gain = effort_change(qp, y)
    return solved, change, gain


@kernel
def effort_measures(arrays: EffortArrays, lam: Array, r: Array) -> tuple[float, float]:
    """The objective, and the largest violation of the limits in the unit of their rows; bounds on λ are met.

    Args:
        arrays: objective and limits.
        lam: (n_a,) efforts.
        r: (3 m,) contact forces.
    """
    at = np.dot(arrays.root_a, lam) + np.dot(arrays.root_c, r)
    linear = np.dot(arrays.c_a, lam) + np.dot(arrays.c_c, r)
    rows, excess = np.dot(arrays.G_a, lam) + np.dot(arrays.G_c, r), 0.0
    for i in range(len(rows)):
        excess = max(excess, rows[i] - arrays.g_hi[i], arrays.g_lo[i] - rows[i])
    return 0.5 * np.dot(at, at) + linear + arrays.constant, excess


@kernel
def effort_reach(
    arrays: EffortArrays, slope: Array, W_ca: Array, span: Array, energy: Array
) -> tuple[float, float]:
    """How far one effort within the limits moves the effectors, and open contacts, at most.

    Args:
        arrays: objective and limits.
        slope: (3 m, n_a) of the contact forces.
        W_ca: (3 m, n_a) of contacts under efforts.
        span: (n_a,) range of the efforts.
        energy: (n_a,) curvatures of the objective that are not of effectors.
    """
    T, A = arrays.root_a + np.dot(arrays.root_c, slope), arrays.G_a + np.dot(arrays.G_c, slope)
    reach, free = 0.0, 0.0
    for j in range(len(span)):
        held, single, pushed = span[j], span[j], np.abs(W_ca[:, j]).max()
        for i in range(len(arrays.g_lo)):
            width = arrays.g_hi[i] - arrays.g_lo[i]
            if A[i, j] != 0.0:
                held = min(held, width / abs(A[i, j]))
            if arrays.G_a[i, j] != 0.0:
                single = min(single, width / abs(arrays.G_a[i, j]))
        moved = np.sqrt(max(np.square(T[:, j]).sum() - energy[j], 0.0))
        reach, free = max(reach, moved * held), max(free, pushed * single)
    return reach, free


@dataclass(frozen=True, slots=True)
class EffortStep:
    """A change of the efforts.

    Attributes:
        change: (n_a,).
        gain: by which the objective falls in the first order of the contact forces.
    """

    change: Array
    gain: float
