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
        asymmetry: largest |w_ij − w_ji| relative to the largest entry, measured where it did not converge:
            the active set takes W for symmetric, so that the residual cannot be much smaller.
    """

    lam: Array
    delta: Array
    residual: float
    iterations: int
    converged: bool
    asymmetry: float = 0.0


def complementarity(W: Array, lam: Array, delta: Array) -> float:
    """Largest |min(w_ii λ_i, δ_i)| [m]; 0 without rows.

    Args:
        W: (m, m) compliance [m/N].
        lam: (m,) forces [N].
        delta: (m,) gaps [m].
    """
    return float(np.abs(np.minimum(np.diag(W) * lam, delta)).max(initial=0.0))


def solve_lcp(
    W: Array,
    delta_free: Array,
    start: Array | None = None,
    rho: float = 1e-9,
    max_iterations: int | None = None,
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
        max_iterations: active sets at most; default 100 + 10 m.
    """
    W, delta_free = np.ascontiguousarray(W), np.ascontiguousarray(delta_free)
    if not (all_finite(W) and all_finite(delta_free)):
        return result_for_bad_data(delta_free)
    start = usable(start, delta_free)
    limit = 100 + 10 * len(delta_free) if max_iterations is None else max_iterations
    lam, iterations = active_set_forces(W, delta_free, start, max(rho, 1e-13), limit)
    result = make_result(W, delta_free, lam, iterations)
    if result.converged or not SHARPEST < rho <= 1e-9 or iterations >= limit:
        return result
    lam, more = active_set_forces(W, delta_free, lam, SHARPEST, limit - iterations)
    again = make_result(W, delta_free, lam, iterations + more)
    return again if again.residual < result.residual else result


def usable(start: Array | None, delta_free: Array) -> Array:
    """Forces to start from (m,), with zeros for entries that are negative or not finite."""
    if start is None:
        return np.zeros_like(delta_free)
    return np.where(np.isfinite(start), np.maximum(start, 0.0), 0.0)


def make_result(W: Array, delta_free: Array, lam: Array, iterations: int) -> LcpResult:
    """The result, with gaps and residual of the original problem.

    Args:
        W: (m, m) compliance [m/N].
        delta_free: (m,) gaps without forces [m].
        lam: (m,) forces [N].
        iterations: that it took.
    """
    delta = delta_free + W @ lam
    residual = complementarity(W, lam, delta)
    asymmetry = 0.0
    if not residual <= TOLERANCE:
        largest = float(np.abs(W).max(initial=0.0))
        asymmetry = float(np.abs(W - W.T).max(initial=0.0)) / largest if largest > 0.0 else 0.0
    return LcpResult(lam, delta, residual, iterations, residual <= TOLERANCE, asymmetry)


def result_for_bad_data(delta_free: Array) -> LcpResult:
    """The result for data that are not finite: no forces, not converged."""
    return LcpResult(np.zeros_like(delta_free), delta_free, np.inf, 0, False)


@kernel
def all_finite(a: Array) -> bool:
    """Whether no entry of a is NaN or infinite."""
    finite = True
    for value in a.flat:
        finite = finite and bool(
            abs(value) < np.inf
        )  # a comparison, since the compiler may reorder sums
    return finite
