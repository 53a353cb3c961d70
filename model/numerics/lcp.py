"""Linear complementarity problems of contact: of each gap and its force at least one is zero.

    0 ≤ δ ⟂ λ ≥ 0,   δ = δ_free + W λ                                            (9), (11)

with W symmetric positive semidefinite. A cable wound to a length has the same form, with
δ = δ_a − pull ≥ 0 ⟂ tension ≥ 0, so contacts and cables may be stacked.

δ is unique. λ is not where W is rank-deficient, which it is when candidates are finer than the mesh.
`solve_lcp` gives the forces of nearly least norm Σ w_ii λ_i², which do not depend on the start.

The residual is max_i |min(w_ii λ_i, δ_i)| [m]. The tolerance of 1e-9 m is far
below the resolution of a mesh and far above the rounding of coordinates in metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics.active_set import active_set_forces
from tauten.model.numerics.arrays import Array
from tauten.model.numerics.jit import kernel

TOLERANCE = 1e-9  # m, residual of a solution


RHO = 1e-9  # regularisation relative to the diagonal of W
SHARPEST = 1e-12  # regularisation that rounding of the factor still allows


@dataclass(frozen=True, slots=True)
class LcpResult:
    """Solution of an LCP.

    Attributes:
        lam: (m,) forces [N], not negative.
        delta: (m,) gaps [m].
        residual: max |min(w_ii λ_i, δ_i)| [m]; +inf when W or delta_free were not finite.
        iterations: active sets that were tried.
        converged: whether the residual is within the tolerance.
    """

    lam: Array
    delta: Array
    residual: float
    iterations: int
    converged: bool


@kernel
def complementarity(W: Array, lam: Array, delta: Array) -> float:
    """Largest |min(w_ii λ_i, δ_i)| [m]; 0 without rows.

    Args:
        W: (m, m) compliance [m/N].
        lam: (m,) forces [N].
        delta: (m,) gaps [m].
    """
    largest = 0.0
    for i in range(len(lam)):  # np.minimum and np.maximum propagate NaN, min and max do not
        largest = np.maximum(largest, np.abs(np.minimum(W[i, i] * lam[i], delta[i])))
    return largest


def solve_lcp(
    W: Array,
    delta_free: Array,
    start: Array | None = None,
    rho: float = RHO,
) -> LcpResult:
    """Solve 0 ≤ δ ⟂ λ ≥ 0 by an active-set method, to rounding apart from the effect of `rho`.

    The forces minimise ½ λᵀ (W + rho diag W) λ + δ_freeᵀ λ over λ ≥ 0. `rho` makes them unique
    where W is singular. Its effect on the gaps is removed at the end, entirely at the default value, mostly
    at larger ones, which distribute the forces more evenly.

    Never raises: for problems without a solution (gaps that no force can open) `converged` is False.

    Args:
        W: (m, m) compliance [m/N].
        delta_free: (m,) gaps without forces [m].
        start: (m,) forces to start from, e.g. those of the last step; they affect the time only.
        rho: regularisation relative to the diagonal of W; where the residual with the default is above
            the tolerance, because W has eigenvalues of its size, SHARPEST is used.
    """
    W, delta_free = np.ascontiguousarray(W), np.ascontiguousarray(delta_free)
    first = np.zeros_like(delta_free) if start is None else np.ascontiguousarray(start, np.float64)
    return LcpResult(*lcp_forces(W, delta_free, first, rho))


@kernel
def lcp_forces(
    W: Array, delta_free: Array, start: Array, rho: float = RHO
) -> tuple[Array, Array, float, int, bool]:
    """The fields of the result, in their order, in one kernel, because each call takes time.

    Args:
        W: (m, m) compliance [m/N].
        delta_free: (m,) gaps without forces [m].
        start: (m,) forces to start from; entries that are negative or not finite are ignored.
        rho: regularisation.
    """
    limit = 100 + 10 * len(delta_free)  # active sets
    if not (all_finite(W) and all_finite(delta_free)):
        return np.zeros_like(delta_free), delta_free, np.inf, 0, False
    usable = np.where(np.abs(start) < np.inf, start, 0.0)
    lam, iterations = active_set_forces(W, delta_free, usable, max(rho, 1e-13), limit)
    delta = delta_free + np.dot(W, lam)
    residual = complementarity(W, lam, delta)
    if not residual <= TOLERANCE and SHARPEST < rho <= 1e-9 and iterations < limit:
        again, more = active_set_forces(W, delta_free, lam, SHARPEST, limit - iterations)
        delta_again = delta_free + np.dot(W, again)
        residual_again = complementarity(W, again, delta_again)
        if residual_again < residual:
            lam, delta, residual = again, delta_again, residual_again
            iterations += more
    return lam, delta, residual, iterations, residual <= TOLERANCE


@kernel
def all_finite(a: Array) -> bool:
    """Whether no entry of a is NaN or infinite."""
    finite = True
    for value in a.flat:
        # a comparison, since the compiler may reorder sums
        finite = finite and bool(abs(value) < np.inf)
    return finite
