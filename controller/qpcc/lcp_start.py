"""A feasible start: the contact forces at given tensions, 0 <= w = N β + q ⟂ β >= 0.

Block principal pivoting (Júdice and Pires 1994) from a guess ends in one or two rounds when the guess
is last step's piece. Lemke's method (Cottle, Pang, Stone, The Linear Complementarity Problem,
algorithm 4.4.5) takes over when it does not, and finds a solution whenever N is positive semidefinite
and there is one.
"""

from __future__ import annotations

import numpy as np

from tauten.controller.qpcc.pieces import eliminate_pushing
from tauten.controller.qpcc.scaling import USABLE, Scaled, Units, examined
from tauten.model.numerics import Array, Bools, Ints, kernel

TOLERANCE = 1e-10  # on β and w, relative to the terms of w
PATIENCE = 3  # rounds without fewer wrong signs before Lemke's method takes over


@kernel
def scaled_start(
    lam_a: Array, guess: Bools, Q: Array, c: Array, lb: Array, ub: Array, G: Array, g_lo: Array,
    g_hi: Array, M: Array, m: Array,
) -> tuple[int, Scaled, Units, Array, bool, Bools, Array]:  # fmt: skip
    """What `examined` says of a QPCC, and the contact forces at given tensions.

    Returns:
        Whether the numbers are USABLE, the scaled problem, its units; the tensions lam_a (n_a,) within their
        bounds; whether contact forces were found there, which modes push, scaled z, as `feasible_start`.
    """
    numbers, scaled, units = examined(Q, c, lb, ub, G, g_lo, g_hi, M, m)
    a = np.minimum(np.maximum(lam_a, lb), ub)
    if numbers != USABLE:
        return numbers, scaled, units, a, False, guess, np.zeros(len(c))
    found, pushes, z = feasible_start(scaled, a / units.column[: len(a)], guess)
    return numbers, scaled, units, a, found, pushes, z


@kernel
def feasible_start(problem: Scaled, a: Array, guess: Bools) -> tuple[bool, Bools, Array]:
    """The contact forces at tensions a: found, which modes push (k,), z = (a, β)."""
    n_a, k = len(a), len(guess)
    N = problem.R[k : 2 * k, n_a:].copy()
    q = problem.r[k : 2 * k] + problem.R[k : 2 * k, :n_a].copy() @ a
    found, pushes, beta = solve_lcp(N, q, guess)
    return found, pushes, np.concatenate((a, beta))


@kernel
def solve_lcp(N: Array, q: Array, guess: Bools) -> tuple[bool, Bools, Array]:
    """Found, which modes push, β."""
    pushes = guess.copy()
    fewest, patience = len(q) + 1, PATIENCE
    while patience > 0:
        beta, wrong = signs(N, q, pushes)
        count = int(np.sum(wrong))
        if count == 0:
            return True, pushes, beta
        if count < fewest:
            fewest, patience = count, PATIENCE
        else:
            patience -= 1
        pushes = pushes != wrong
    pushes = lemke(N, q)
    beta, wrong = signs(N, q, pushes)
    return not np.any(wrong), pushes, beta


@kernel
def signs(N: Array, q: Array, pushes: Bools) -> tuple[Array, Bools]:
    """β of a piece, and the modes whose β (pushing) or w (open) has the wrong sign."""
    k = len(q)
    pushing = eliminate_pushing(N, q, np.flatnonzero(pushes), 0)
    beta = np.zeros(k)
    for s in range(pushing.rank):
        beta[pushing.cols[s]] = pushing.beta[s, -1]
    wrong = np.zeros(k, dtype=np.bool_)
    for i in range(k):
        w, size = q[i], abs(q[i])
        for j in range(k):
            w += N[i, j] * beta[j]
            size += abs(N[i, j] * beta[j])
        if pushes[i]:
            wrong[i] = beta[i] * abs(N[i, i]) < -TOLERANCE * size or abs(w) > TOLERANCE * size
            beta[i] = max(beta[i], 0.0)
        else:
            wrong[i] = w < -TOLERANCE * size
    return beta, wrong


@kernel
def lemke(N: Array, q: Array) -> Bools:
    """The modes that push in the basis Lemke's method ends in; the caller checks it."""
    k = len(q)
    pushes = np.zeros(k, dtype=np.bool_)
    if k == 0 or np.min(q) >= 0.0:
        return pushes
    tableau = np.zeros((k, 2 * k + 2))  # w, β, artificial, right-hand side
    tableau[:, :k] = np.eye(k)
    tableau[:, k : 2 * k] = -N
    tableau[:, 2 * k] = -1.0
    tableau[:, 2 * k + 1] = q
    basis = np.arange(k)
    row, entering = int(np.argmin(q)), 2 * k
    for _ in range(20 * k + 20):
        leaving = int(basis[row])
        pivot(tableau, row, entering)
        basis[row] = entering
        entering = leaving + k if leaving < k else leaving - k
        if leaving == 2 * k:
            break
        row = ratio_test(tableau, basis, entering)
        if row < 0:
            break
    for i in range(k):
        if k <= basis[i] < 2 * k:
            pushes[basis[i] - k] = True
    return pushes


@kernel
def pivot(tableau: Array, row: int, column: int) -> None:
    """Gauss-Jordan step."""
    tableau[row] /= tableau[row, column]
    for i in range(len(tableau)):
        factor = tableau[i, column]
        if i != row and factor != 0.0:
            for j in range(tableau.shape[1]):
                tableau[i, j] -= factor * tableau[row, j]


@kernel
def ratio_test(tableau: Array, basis: Ints, entering: int) -> int:
    """Row that blocks first; the artificial variable leaves whenever it may. -1: a ray."""
    best, chosen = np.inf, -1
    for i in range(len(tableau)):
        if tableau[i, entering] > 1e-11:
            ratio = tableau[i, -1] / tableau[i, entering]
            artificial = basis[i] == 2 * len(tableau)
            if ratio < best * (1.0 - 1e-12) or (artificial and ratio <= best * (1.0 + 1e-12)):
                best, chosen = min(ratio, best), i
    return chosen
