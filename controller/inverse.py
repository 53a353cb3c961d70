"""The inverse problem (T1): which tensions bring the effectors to their target within one step."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from tauten.controller.compliance import Response
from tauten.controller.qpcc import Qpcc
from tauten.model import Limits
from tauten.model.numerics import Array, Bools, cholesky, kernel, solve_rows


def inverse_problem(
    response: Response,
    target: Array,
    limits: Limits,
    pull_prev: Array,
    h: float,
    epsilon: float,
    touching: Bools | None = None,
) -> Qpcc:
    """Build (T1); pure, nothing is solved.

    min  1/2 |δ_e|² + 1/2 ε s λ_a' W_aa λ_a,   δ_e = δ_e,free - target + W_ea λ_a + W_ec β
    s.t. tension limits,   pull and rate limits on δ_a,   0 <= δ_c ⟂ β >= 0

    s = |W̃_ea|² / tr W_aa [m/N] makes ε unitless: the share of the objective's curvature that is spent on
    the elastic energy of the cables. W̃ is the compliance with the contacts that touch kept shut: where a
    robot rests on itself its cables move the effectors a hundred times less, and an energy weighed by what
    they move freely would win against the target. Without any coupling s = tr W_aa / n_a.

    Args:
        response: compliances and free motion, with effector positions in the effector rows.
        target: (n_e,) positions [m].
        limits: of the cables.
        pull_prev: (n_a,) pulled lengths commanded last [m].
        h: time step [s].
        epsilon: weight of the elastic energy, unitless.
        touching: (k,) contacts that pushed last; None for none.
    """
    n_e, n_a, k = response.n_e, response.n_a, response.n_c
    W, delta_free = response.W, response.delta_free
    shut_now = np.zeros(k, dtype=np.bool_) if touching is None else touching
    Q, c, constant, g_lo, g_hi, slower = _arrays(
        W, delta_free, target, pull_prev, limits.pull_min, limits.pull_max, limits.rate, h, epsilon, shut_now,
    )  # fmt: skip
    return Qpcc(
        Q=Q,
        c=c,
        lb=limits.tension_min,
        ub=limits.tension_max,
        G=W[n_e : n_e + n_a, n_e:],
        g_lo=g_lo,
        g_hi=g_hi,
        M=W[n_e + n_a :, n_e:],
        m=delta_free[n_e + n_a :],
        constant=constant,
        bound_names=tension_names(n_a),
        row_names=pull_names(slower.tobytes()),
    )


def shut(response: Response, touching: Bools | None) -> Array:
    """W̃_ea = W_ea − W_ec W_cc⁻¹ W_ca over the contacts that touch: (n_e, n_a) [m/N].

    Redundant contacts make W_cc singular, and so does one that no force opens; a regularisation leaves the
    product as it is.
    """
    if touching is None:
        return response.W[: response.n_e, response.n_e : response.n_e + response.n_a]
    return _shut(response.W, response.n_e, response.n_a, touching)


@kernel
def _shut(W: Array, n_e: int, n_a: int, touching: Bools) -> Array:
    """W̃_ea of `shut`."""
    W_ea = W[:n_e, n_e : n_e + n_a].copy()
    c = n_e + n_a + np.flatnonzero(touching)
    m = len(c)
    W_cc, L, rows = np.empty((m, m)), np.zeros((m, m)), np.empty((n_a, m))
    for i in range(m):
        for j in range(m):
            W_cc[i, j] = W[c[i], c[j]]
        for j in range(n_a):
            rows[j, i] = W[n_e + j, c[i]]
    trace = np.trace(W_cc)
    for i in range(m):
        W_cc[i, i] += 1e-9 * trace / m if trace > 0.0 else 1.0
    if not cholesky(W_cc, L):  # not finite
        return W_ea
    pushes = solve_rows(L, rows)  # (n_a, m)
    for i in range(n_e):
        for j in range(n_a):
            for k in range(m):
                W_ea[i, j] -= W[i, c[k]] * pushes[j, k]
    return W_ea


@kernel
def energy_scale(W_ea: Array, W_aa: Array) -> float:
    """What makes ε unitless [m/N]."""
    trace = float(np.trace(W_aa))
    if not trace > 0.0:
        return 0.0
    coupling = float(np.sum(W_ea * W_ea))
    return coupling / trace if coupling > 0.0 else trace / W_aa.shape[0]


@kernel
def _arrays(
    W: Array, delta_free: Array, target: Array, pull_prev: Array, pull_min: Array, pull_max: Array,
    rate: Array, h: float, epsilon: float, touching: Bools,
) -> tuple[Array, Array, float, Array, Array, Bools]:  # fmt: skip
    """Objective and travel, see there: what of (T1) is not just a part of W or δ_free."""
    n_e, n_a = len(target), len(pull_prev)
    Q, c, constant = _objective(W, delta_free, target, n_a, epsilon, touching)
    free = delta_free[n_e : n_e + n_a]
    return Q, c, constant, *_travel(free, pull_prev, pull_min, pull_max, rate, h)


@kernel
def _objective(
    W: Array, delta_free: Array, target: Array, n_a: int, epsilon: float, touching: Bools
) -> tuple[Array, Array, float]:
    """Q (n, n), c (n,) and constant of (T1), n = n_a + k."""
    n_e, n = len(target), W.shape[0] - len(target)
    W_aa = W[n_e : n_e + n_a, n_e : n_e + n_a].copy()
    weight = epsilon * energy_scale(_shut(W, n_e, n_a, touching), W_aa)
    Q, c, constant = np.zeros((n, n)), np.zeros(n), 0.0
    for e in range(n_e):
        error = delta_free[e] - target[e]
        constant += 0.5 * error * error
        for i in range(n):
            c[i] += W[e, n_e + i] * error
            for j in range(n):
                Q[i, j] += W[e, n_e + i] * W[e, n_e + j]
    Q[:n_a, :n_a] += weight * W_aa
    return Q, c, constant


@kernel
def _travel(
    free: Array, pull_prev: Array, pull_min: Array, pull_max: Array, rate: Array, h: float
) -> tuple[Array, Array, Bools]:
    """Limits of δ_a − δ_a,free, each (n_a,) [m], and whether it is the rate that sets them (n_a, 2)."""
    n_a = len(free)
    g_lo, g_hi, slower = np.empty(n_a), np.empty(n_a), np.empty((n_a, 2), np.bool_)
    for a in range(n_a):
        low, high = pull_prev[a] - h * rate[a], pull_prev[a] + h * rate[a]
        slower[a, 0], slower[a, 1] = low > pull_min[a], high < pull_max[a]
        # these pass NaN on, max and min do not
        g_lo[a] = np.maximum(pull_min[a], low) - free[a]
        g_hi[a] = np.minimum(pull_max[a], high) - free[a]
    return g_lo, g_hi, slower


@lru_cache(maxsize=64)
def tension_names(n_a: int) -> tuple[str, ...]:
    """Names of the tension limits."""
    return tuple(f"tension of cable {i}" for i in range(n_a))


@lru_cache(maxsize=1024)
def pull_names(slower: bytes) -> tuple[tuple[str, str], ...]:
    """Names of the limits of the pulled lengths: rate or pull, whichever is tighter.

    Args:
        slower: for the lower and the upper limit of each cable, whether it is the rate.
    """
    pairs = enumerate(zip(slower[::2], slower[1::2], strict=True))
    return tuple(
        (
            f"{'rate' if low else 'pull_min'} of cable {i}",
            f"{'rate' if high else 'pull_max'} of cable {i}",
        )
        for i, (low, high) in pairs
    )
