"""A feasible start: the contact forces at given tensions, 0 <= w = N β + q ⟂ β >= 0.

Block principal pivoting (Júdice and Pires 1994) from a guess ends in one or two rounds when the guess is
last step's piece; Lemke's method (Cottle, Pang, Stone, The Linear Complementarity Problem, algorithm 4.4.5)
takes over when it does not, and finds a solution whenever N is positive semidefinite and there is one.
"""

from __future__ import annotations

import numpy as np
from tauten.controller.qpcc_pieces import solve_for_pushing
from tauten.model.arrays import Array, Bools
from tauten.model.jit import kernel

TOLERANCE = 1e-10  # on w and β, relative to the terms of w


@kernel
def solve_lcp(N: Array, q: Array, guess: Bools) -> tuple[bool, Bools]:
    """Which modes push in a solution of the LCP (k,); False first when none was found."""
    pushes = guess.copy()
    fewest = len(q) + 1
    patience = 3
    while patience > 0:
        wrong = wrong_signs(N, q, pushes)
        count = int(np.sum(wrong))
        if count == 0:
            return True, pushes
        if count < fewest:
            fewest, patience = count, 3
        else:
            patience -= 1
        pushes = pushes != wrong
    pushes = lemke(N, q)
    return not np.any(wrong_signs(N, q, pushes)), pushes


@kernel
def wrong_signs(N: Array, q: Array, pushes: Bools) -> Bools:
    """Modes whose β (pushing) or w (open) is negative when w_I = 0 and β_J = 0."""
    k = len(q)
    rank, _, cols, _, expression = solve_for_pushing(N, q, np.flatnonzero(pushes), 0)
    beta = np.zeros(k)
    for s in range(rank):
        beta[cols[s]] = expression[s, expression.shape[1] - 1]
    wrong = np.zeros(k, dtype=np.bool_)
    for i in range(k):
        w, size = q[i], abs(q[i])
        for j in range(k):
            w += N[i, j] * beta[j]
            size += abs(N[i, j] * beta[j])
        if pushes[i]:
            wrong[i] = beta[i] * abs(N[i, i]) < -TOLERANCE * size or abs(w) > TOLERANCE * size
        else:
            wrong[i] = w < -TOLERANCE * size
    return wrong


@kernel
def lemke(N: Array, q: Array) -> Bools:
    """The basis Lemke's method ends in; the caller checks it."""
    k = len(q)
    tableau = np.zeros((k, 2 * k + 2))  # w, β, artificial, right-hand side
    for i in range(k):
        tableau[i, i] = 1.0
        for j in range(k):
            tableau[i, k + j] = -N[i, j]
        tableau[i, 2 * k] = -1.0
        tableau[i, 2 * k + 1] = q[i]
    basis = np.arange(k)
    row, entering = int(np.argmin(q)), 2 * k
    if q[row] >= 0.0:
        return np.zeros(k, dtype=np.bool_)
    for _ in range(20 * k + 20):
        leaving = basis[row]
        pivot(tableau, row, entering)
        basis[row] = entering
        if leaving == 2 * k:
            break
        entering = leaving + k if leaving < k else leaving - k
        row = ratio_test(tableau, basis, entering, 2 * k)
        if row < 0:
            break
    pushes = np.zeros(k, dtype=np.bool_)
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
def ratio_test(tableau: Array, basis: Array, entering: int, artificial: int) -> int:
    """Row that blocks first; the artificial variable leaves whenever it may. -1: a ray."""
    best, chosen = np.inf, -1
    last = tableau.shape[1] - 1
    for i in range(len(tableau)):
        if tableau[i, entering] > 1e-11:
            ratio = tableau[i, last] / tableau[i, entering]
            if ratio < best * (1.0 - 1e-12) or (ratio <= best and basis[i] == artificial):
                best, chosen = ratio, i
    return chosen
