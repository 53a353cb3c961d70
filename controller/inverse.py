"""The inverse problem (T1): which tensions bring the effectors to their target within one step."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from tauten.controller.compliance import Response
from tauten.controller.qpcc import Qpcc
from tauten.model.arrays import Array, Bools
from tauten.model.jit import kernel
from tauten.model.limits import Limits
from tauten.reduction.dense_factors import cholesky, solve_rows


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
    n_e, n_a = response.n_e, response.n_a
    e, a, c = slice(0, n_e), slice(n_e, n_e + n_a), slice(n_e + n_a, len(response.delta_free))
    W, z = response.W, slice(n_e, len(response.delta_free))
    error = response.delta_free[e] - target  # (n_e,)
    Q = W[e, z].T @ W[e, z]  # (n_a + k, n_a + k)
    Q[:n_a, :n_a] += epsilon * energy_scale(shut(response, touching), W[a, a]) * W[a, a]
    reach = h * limits.rate  # (n_a,)
    free = response.delta_free[a]
    return Qpcc(
        Q=Q,
        c=W[e, z].T @ error,
        lb=limits.tension_min,
        ub=limits.tension_max,
        G=W[a, z],
        g_lo=np.maximum(limits.pull_min, pull_prev - reach) - free,
        g_hi=np.minimum(limits.pull_max, pull_prev + reach) - free,
        M=W[c, z],
        m=response.delta_free[c],
        constant=0.5 * float(error @ error),
        bound_names=tension_names(n_a),
        row_names=pull_names(
            tuple(limits.pull_min >= pull_prev - reach), tuple(limits.pull_max <= pull_prev + reach)
        ),
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


@lru_cache(maxsize=64)
def tension_names(n_a: int) -> tuple[str, ...]:
    """Names of the tension limits."""
    return tuple(f"tension of cable {i}" for i in range(n_a))


@lru_cache(maxsize=1024)
def pull_names(
    lower_is_pull: tuple[bool, ...], upper_is_pull: tuple[bool, ...]
) -> tuple[tuple[str, str], ...]:
    """Names of the limits of the pulled lengths: pull or rate, whichever is tighter."""
    pairs = enumerate(zip(lower_is_pull, upper_is_pull, strict=True))
    return tuple(
        (
            f"{'pull_min' if low else 'rate'} of cable {i}",
            f"{'pull_max' if high else 'rate'} of cable {i}",
        )
        for i, (low, high) in pairs
    )
