"""One implicit step with dense matrices: `tauten.model.system.make_system` in reduced coordinates."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tauten.model import Integration, System
from tauten.model.numerics import (
    Array,
    DenseFactors,
    FactorisationError,
    cholesky,
    kernel,
    solve_in_place,
)


class Scheme(NamedTuple):
    """Damping and time step; a tuple because kernels accept it directly.

    Attributes:
        h: time step [s].
        static: whether inertia and damping are left out.
        a: of the Rayleigh damping a M + b_K D [1/s].
        b_K: of the Rayleigh damping [s].
        ahead: whether the state is that to which its velocity leads from the start of the step.
    """

    h: float
    static: bool
    a: float
    b_K: float
    ahead: bool


def scheme_of(integration: Integration) -> Scheme:
    """An integration as kernels take it."""
    return Scheme(
        integration.h,
        integration.static,
        integration.rayleigh_mass,
        integration.rayleigh_stiffness,
        integration.ahead,
    )


@kernel
def implicit_step(
    scheme: Scheme, mass: Array, D: Array, K: Array, force: Array, v: Array, L: Array, v_free: Array
) -> bool:
    """Factors of A into L and the velocity after a step without constraint forces into v_free (7)-(10).

    Where the scheme is linearised ahead, its change.

    Args:
        scheme: damping and time step.
        mass: (r, r), not read where the scheme is static.
        D: (r, r) stiffness of the material, to which damping is proportional; not read where static.
        K: (r, r) tangent.
        force: (r,) without constraint forces.
        v: (r,) velocity.
        L: (r, r) output, lower Cholesky factor.
        v_free: (r,) output.

    Returns:
        Whether A is positive definite; where it is not, v_free is of no use.
    """
    h, a, b_K = scheme.h, scheme.a, scheme.b_K
    if scheme.static:
        A = h * h * K
        v_free[:] = h * force
    else:
        A = (1.0 + h * a) * mass + h * b_K * D + h * h * K
        v_free[:] = h * (force - a * np.dot(mass, v) - b_K * np.dot(D, v))
        if not scheme.ahead:
            v_free[:] -= h * h * np.dot(K, v)
    if not cholesky(A, L):
        return False
    solve_in_place(L, v_free)
    if not (scheme.static or scheme.ahead):
        v_free[:] += v
    return True


def implicit_system(
    scheme: Scheme,
    mass: Array,
    D: Array,
    forces: Callable[[bool], tuple[Array, Array]],
    v: Array,
    L: Array,
    inertia: Array | None = None,
) -> System:
    """The system of one step, with the exact tangent where it is positive definite.

    Args:
        scheme: damping and time step.
        mass: (r, r), not read where the scheme is static.
        D: (r, r) stiffness of the material, not read either.
        forces: forces (r,) and tangent (r, r), exact or not, see `ReducedRobot.forces`.
        v: (r,) velocity.
        L: (r, r) memory of the factor.
        inertia: (r,) forces of inertia at constant velocities; None: there are none.

    Raises:
        FactorisationError: neither matrix is positive definite (a state that has blown up).
    """
    v_free = np.empty_like(v)
    for exact in (True, False):  # buckling makes the exact tangent indefinite
        force, K = forces(exact)
        moving = force if inertia is None else force - inertia
        if implicit_step(scheme, mass, D, K, moving, v, L, v_free):
            residual = float(np.linalg.norm(force))
            tangent = K if scheme.static else None
            before = np.zeros_like(v) if scheme.ahead else v
            return System(scheme.h, before, v_free, residual, DenseFactors(L), exact, tangent)
    raise FactorisationError("the reduced model's matrix is not positive definite")
