"""Kernels of the QPCC's pieces: eliminate what a piece fixes, and read its multipliers back.

All constraints but the bounds on a are rows of one matrix,

    R = (β; M; G),   lo <= R z + r <= hi,   r = (0; m; 0)                                        (4)

2k + p of them, and a piece fixes one row of every pair at zero: w_i = 0 where mode i pushes, β_i = 0 where
it is open. The equations w_I = 0 give β_I as an affine function of a, so that a QP in a alone is left, n_a
variables instead of n_a + k. Where M_II is singular (duplicate modes), as many β as it lacks in rank stay
variables.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from tauten.controller.elimination import back_substitute, eliminate, solve_transposed
from tauten.controller.qp import UNBOUNDED
from tauten.model.arrays import Array, Bools, Ints
from tauten.model.jit import kernel

# scale τ, map T and offset t of z = τ T ŷ + t, rows of R in the QP, rank, pivot rows and columns, LU
Reduction: TypeAlias = tuple[float, Array, Array, Ints, int, Ints, Ints, Array]

CONSTANT = 1e-11  # a row whose coefficients are this small beside its terms does not depend on y
SLACK = 1e-10  # how far a constant row may lie outside its limits, relative to its terms


@kernel
def solve_for_pushing(
    M: Array, m: Array, pushing: Ints, n_a: int
) -> tuple[int, Ints, Ints, Array, Array]:
    """β_I from w_I = 0: rank, rows and columns in the order of the pivots (as modes), LU, expression.

    The expression is (p, n_a + p - rank + 1): row s < rank holds the coefficients of β_{cols[s]} in
    (a, the p - rank dependent β, 1).
    """
    p = len(pushing)
    E = np.empty((p, p))
    expression = np.zeros((p, n_a + p + 1))
    for i in range(p):
        for j in range(p):
            E[i, j] = M[pushing[i], n_a + pushing[j]]
        for j in range(n_a):
            expression[i, j] = -M[pushing[i], j]
        expression[i, n_a] = -m[pushing[i]]
    rank, rows, cols = eliminate(E, expression)
    free = p - rank
    for i in range(rank):
        expression[i, n_a + free] = expression[i, n_a]
        for j in range(free):
            expression[i, n_a + j] = -E[i, rank + j]
    back_substitute(E, expression, rank)
    return rank, pushing[rows], pushing[cols], E, expression[:, : n_a + free + 1]


@kernel
def affine_map(
    expression: Array, cols: Ints, rank: int, n_a: int, k: int
) -> tuple[Array, Array, Ints]:
    """Z = T y + t with y = (a, dependent β): T (n, n_y), t (n,), and which z are not fixed at 0."""
    free = len(cols) - rank
    T = np.zeros((n_a + k, n_a + free))
    t = np.zeros(n_a + k)
    for j in range(n_a):
        T[j, j] = 1.0
    for j in range(free):
        T[n_a + cols[rank + j], n_a + j] = 1.0
    for s in range(rank):
        T[n_a + cols[s]] = expression[s, : n_a + free]
        t[n_a + cols[s]] = expression[s, n_a + free]
    return T, t, np.concatenate((np.arange(n_a), n_a + cols))


@kernel
def reduced_objective(Q: Array, c: Array, T: Array, t: Array, live: Ints) -> tuple[Array, Array]:
    """T'QT and T'(Qt + c), summed over the `live` variables only."""
    n_y, p = T.shape[1], len(live)
    QT = np.zeros((p, n_y))
    q = np.empty(p)
    for r in range(p):
        q[r] = c[live[r]]
        for s in range(p):
            value = Q[live[r], live[s]]
            q[r] += value * t[live[s]]
            for j in range(n_y):
                QT[r, j] += value * T[live[s], j]
    H = np.zeros((n_y, n_y))
    f = np.zeros(n_y)
    for r in range(p):
        for j in range(n_y):
            value = T[live[r], j]
            f[j] += value * q[r]
            for l in range(j + 1):
                H[j, l] += value * QT[r, l]
    for j in range(n_y):
        for l in range(j):
            H[l, j] = H[j, l]
    return H, f


@kernel
def reduced_rows(
    R: Array,
    r: Array,
    lo: Array,
    hi: Array,
    fixed: Bools,
    skip: Bools,
    T: Array,
    t: Array,
    live: Ints,
) -> tuple[bool, int, Array, Array, Array, Ints]:
    """Rows (4) in terms of y: possible, count, A, low, high, and which row of R each one is.

    A row that does not depend on y is left out when it holds; when it does not, the piece is empty.
    """
    n_y, p = T.shape[1], len(live)
    A = np.zeros((len(r), n_y))
    low, high = np.empty(len(r)), np.empty(len(r))
    source = np.empty(len(r), dtype=np.int64)
    count = 0
    for i in range(len(r)):
        if skip[i]:
            continue
        constant, size, largest, scale = r[i], abs(r[i]), 0.0, 0.0
        row = A[count]
        row[:] = 0.0
        for s in range(p):
            value = R[i, live[s]]
            if value != 0.0:
                constant += value * t[live[s]]
                size += abs(value * t[live[s]])
                for j in range(n_y):
                    row[j] += value * T[live[s], j]
                    scale = max(scale, abs(value * T[live[s], j]))
        for j in range(n_y):
            largest = max(largest, abs(row[j]))
        upper = lo[i] if fixed[i] else hi[i]
        if largest <= CONSTANT * scale:
            slack = SLACK * (size + min(abs(lo[i]), abs(upper)))
            if constant < lo[i] - slack or constant > upper + slack:
                return False, 0, A, low, high, source
            continue
        low[count] = max(lo[i] - constant, -UNBOUNDED)
        high[count] = min(upper - constant, UNBOUNDED)
        source[count] = i
        count += 1
    return True, count, A, low, high, source


@kernel
def scale_reduced(
    H: Array, f: Array, A: Array, low: Array, high: Array, bounds: tuple[Array, Array], T: Array
) -> tuple[float, Array, Array]:
    """Change to y = τ s ŷ, in place, so that Ĥ has a unit diagonal and ŷ is of order one.

    Returns:
        τ and the bounds (n_y + rows,) on (ŷ, A ŷ). T is multiplied by s, not by τ.
    """
    n_y, rows = len(f), len(low)
    lower, upper = np.empty(n_y + rows), np.empty(n_y + rows)
    largest = 0.0
    for j in range(n_y):
        largest = max(largest, H[j, j])
    s = np.ones(n_y)
    for j in range(n_y):
        if H[j, j] > 1e-14 * largest:
            s[j] = 1.0 / np.sqrt(H[j, j])
    tau = 0.0
    for j in range(n_y):
        f[j] *= s[j]
        T[:, j] *= s[j]
        tau = max(tau, abs(f[j]))
        for l in range(n_y):
            H[j, l] *= s[j] * s[l]
        lower[j], upper[j] = bounds[0][j] / s[j], bounds[1][j] / s[j]
        tau = max(tau, lower[j], -upper[j])
    for i in range(rows):
        norm = 0.0
        for j in range(n_y):
            A[i, j] *= s[j]
            norm += A[i, j] ** 2
        tau = max(tau, max(low[i], -high[i]) / np.sqrt(norm))
        lower[n_y + i], upper[n_y + i] = low[i], high[i]
    if tau == 0.0:
        tau = 1.0
    f /= tau
    for i in range(n_y + rows):
        lower[i] = max(lower[i] / tau, -UNBOUNDED) if lower[i] > -UNBOUNDED else -UNBOUNDED
        upper[i] = min(upper[i] / tau, UNBOUNDED) if upper[i] < UNBOUNDED else UNBOUNDED
    return tau, lower, upper


@kernel
def reduce_piece(
    Q: Array, c: Array, lb: Array, ub: Array, R: Array, r: Array, lo: Array, hi: Array, pushes: Bools
) -> tuple[bool, Array, Array, Array, Array, Array, Reduction]:  # fmt: skip
    """The QP of a piece in ŷ and the way back to z.

    Returns:
        Whether it can have a point; H, f, A, lower, upper as in `qp.Qp`; what `recover` needs.
    """
    k, n_a = len(pushes), len(lb)
    pushing = np.flatnonzero(pushes)
    M, m = R[k : 2 * k], r[k : 2 * k]
    rank, rows, cols, E, expression = solve_for_pushing(M, m, pushing, n_a)
    T, t, live = affine_map(expression, cols, rank, n_a, k)
    free = len(cols) - rank
    fixed = np.zeros(len(r), dtype=np.bool_)
    skip = np.zeros(len(r), dtype=np.bool_)
    skip[:k] = True
    skip[cols[:rank]] = False
    skip[k + rows[:rank]] = True
    fixed[k + pushing] = True
    possible, count, A, low, high, source = reduced_rows(R, r, lo, hi, fixed, skip, T, t, live)
    A, low, high, source = A[:count], low[:count], high[:count], source[:count]
    H, f = reduced_objective(Q, c, T, t, live)
    bounds = (
        np.concatenate((lb, np.zeros(free))),
        np.concatenate((ub, np.full(free, UNBOUNDED))),
    )
    tau, lower, upper = scale_reduced(H, f, A, low, high, bounds, T)
    return possible, H, f, A, lower, upper, (tau, T, t, source, rank, rows, cols, E)


@kernel
def recover(
    Q: Array, c: Array, lb: Array, ub: Array, R: Array, pushes: Bools,
    reduction: Reduction, y: Array, multipliers: Array,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Z (n,), multipliers of the bounds (n_a,) and of all rows (4) from a piece's QP.

    Signs are those of `qp.QpAnswer`: Qz + c + (bounds) + R'(rows) = 0, positive where an upper limit holds.
    The multipliers of the eliminated equations w_I = 0 follow from the columns of β_I, those of the fixed
    β_J from their own columns.
    """
    tau, T, t, source, rank, rows, cols, E = reduction
    n_a, k = len(lb), len(pushes)
    n, n_y = n_a + k, len(y)
    z = t.copy()
    for i in range(n):
        for j in range(n_y):
            z[i] += tau * T[i, j] * y[j]
    for j in range(n_a):
        at_bound = lb[j] if multipliers[j] < 0.0 else ub[j]
        z[j] = at_bound if multipliers[j] != 0.0 else min(max(z[j], lb[j]), ub[j])
    for i in range(k):
        z[n_a + i] = max(z[n_a + i], 0.0) if pushes[i] else 0.0
    alpha, dual = np.zeros(n_a), np.zeros(len(R))
    for j in range(n_a):
        alpha[j] = tau * multipliers[j] / T[j, j]
    for j in range(n_a, n_y):
        i = cols[rank + j - n_a]
        dual[i] = tau * multipliers[j] / T[n_a + i, j]
    for i in range(len(source)):
        dual[source[i]] = tau * multipliers[n_y + i]
    x = np.empty(rank)
    for s in range(rank):
        x[s] = -gradient(Q, c, R, z, dual, n_a + cols[s])
    solve_transposed(E, x, rank)
    for s in range(rank):
        dual[k + rows[s]] += x[s]
    for i in range(k):
        if not pushes[i]:
            dual[i] = -gradient(Q, c, R, z, dual, n_a + i)
    return z, alpha, dual


@kernel
def gradient(Q: Array, c: Array, R: Array, z: Array, dual: Array, j: int) -> float:
    """Entry j of Qz + c + R'dual."""
    total = c[j]
    for i in range(len(z)):
        total += Q[i, j] * z[i]
    for i in range(len(dual)):
        total += R[i, j] * dual[i]
    return total
