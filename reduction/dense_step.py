"""One implicit step with dense matrices: `tauten.model.system.make_system` in reduced coordinates."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy.linalg import eigh
from scipy.linalg.lapack import dpotrf

from tauten.model import (
    Assembled,
    Augmentation,
    Integration,
    Scheme,
    System,
    Tangent,
    tried_tangents,
)
from tauten.model.body import RATES, has_lost_digits
from tauten.model.numerics import (
    Array,
    DenseFactors,
    FactorisationError,
    Ints,
    cholesky,
    kernel,
    solve_in_place,
)

MASSLESS = 1e-9  # eigenvalue of a scaled mass matrix, relative to the largest, that is rounding
LEAST = 0.1  # of a matrix with the stiffness of the material, that one with an augmented tangent is


@dataclass(frozen=True, slots=True, eq=False)
class DenseAssembled(Assembled):
    """What all reduced bodies know of a state; attributes beside those of `Assembled`.

    Attributes:
        mass: (r, r), read in static steps where something floats.
        force: (r,) without actuators and contacts.
        inertia: (r,) centrifugal forces; None: there are none.
        resisting: (r,) D v: what damping is proportional to.
        floats: whether bodies that nothing holds move by their inertia, `mass`, in a static step.
    """

    mass: Array
    force: Array
    inertia: Array | None
    resisting: Array
    floats: bool = field(default=False, kw_only=True)

    def augmentation(self, H: Array, rho: Array) -> tuple[Augmentation, Array]:
        """What adds ρ_i h_iᵀ h_i to the tangent, see `Assembled`."""
        return (rho * H.T) @ H, rho


@kernel
def implicit_step(
    scheme: Scheme, mass: Array, forces: tuple[Array, Array], S: Array, v: Array, L: Array,
    v_free: Array,
) -> bool:  # fmt: skip
    """Factors of A into L and the velocity after a step without constraint forces into v_free (7)-(10).

    Less the share of the velocity whose way the state has made.

    Args:
        scheme: damping and time step.
        mass: (r, r), not read where the scheme is static.
        forces: (r,) without constraint forces, and D v; the second is read where the state is ahead.
        S: (r, r) h b_K D + h² K, of a static scheme h² K.
        v: (r,) velocity.
        L: (r, r) output, lower Cholesky factor.
        v_free: (r,) output.

    Returns:
        Whether A is positive definite; where it is not, v_free is of no use.
    """
    h, a = scheme.h, scheme.a
    force, resisting = forces
    if scheme.static:
        if not cholesky(S, L):
            return False
        v_free[:] = h * force
    else:
        if not cholesky((1.0 + h * a) * mass + S, L):
            return False
        v_free[:] = h * force - h * a * np.dot(mass, v)
        if scheme.ahead > 0.0:
            v_free[:] -= scheme.ahead * h * scheme.b_K * resisting
        if scheme.ahead < 1.0:
            v_free[:] -= (1.0 - scheme.ahead) * np.dot(S, v)
    solve_in_place(L, v_free)
    if not scheme.static:
        v_free[:] += (1.0 - scheme.ahead) * v
    return True


def implicit_system(
    integration: Integration,
    at: DenseAssembled,
    stiffness: Callable[[bool], Array],
    material: Callable[[], Array],
    L: Array,
    driven: Ints | None = None,
    added: Augmentation = None,
    loose: Array | None = None,
) -> System:
    """The system of one step, with the exact tangent where A is positive definite.

    Where it is not, stiffness on the diagonal of drives is tried before the semidefinite tangent: at given
    torques a body may be unstable that a drive holds, and a drive that is held changes no step towards
    equilibrium. Where the tangent is augmented, see `Assembled.augmentation`, as much of the material's
    stiffness takes its place as keeps A from becoming singular.

    Args:
        integration: scheme and length of the step.
        at: the state where the step starts.
        stiffness: S of `implicit_step` (r, r), with the exact tangent or the semidefinite one.
        material: the same with the stiffness of the material D for K.
        L: (r, r) memory of the factor.
        driven: (d,) unknowns that drives move; None: there are none.
        added: (r, r) to the tangent; None: nothing.
        loose: (r, r) mass of a body of which nothing may hold a part, read in static steps; None: it is held.

    Raises:
        FactorisationError: neither matrix is positive definite (a state that has blown up).
    """
    n, scheme = len(at.force), integration.numbers
    if at.floats:  # the velocity of all else has no mass: (M + h² K) (v + dv) = h f + M v
        scheme = scheme._replace(static=False, b_K=0.0)
    v = np.zeros(n) if scheme.static else at.state.v
    force = at.force if at.inertia is None else at.force + at.inertia
    forces, v_free = (force, at.resisting), np.empty(n)
    derivative = stiffness(True)
    assert not isinstance(added, tuple)
    others: Iterator[Tangent] | None = None  # tried where the exact tangent has no factor
    S, exact, share = derivative, True, 0.0
    stiffened: tuple[Ints, Array] | None = None
    unheld = unheld_in(derivative, scheme.h, driven, loose) if integration.static else None
    attempts = partial(with_mass, integration, derivative, lambda: stiffness(False), loose)
    if added is not None:
        added = integration.shares[1] * added
        rest = added if scheme.static else (1.0 + scheme.h * scheme.a) * at.mass + added
        (S, exact, share), others = bounded_tangent(derivative, material(), rest), iter(())
    elif integration.semidefinite > 0.0:
        others = attempts()
        S, exact, share = next(others)[:3]
    A_K = S if added is None else S + added
    while not implicit_step(scheme, at.mass, forces, A_K, v, L, v_free) or (
        exact and unheld is not None and has_lost_digits(DenseFactors(L), scheme.h, n, unheld)
    ):
        if others is None:
            others = attempts()
            if driven is not None and len(driven) > 0:
                others = with_drives_stiffer(others, integration, at.mass, material, driven)
            next(others)  # the exact one
        following = next(others, None)
        if following is None:
            raise FactorisationError("the reduced model's matrix is not positive definite")
        S, exact, share, stiffened, _ = following
        A_K = S
    if 0.0 < scheme.ahead < 1.0 and not exact:  # the derivative leads the rest of the way
        v_free += DenseFactors(L).solve((1.0 - scheme.ahead) * (S - derivative) @ v)
    residual = math.sqrt(at.force @ at.force)
    tangent = A_K / scheme.h**2 if scheme.static else None
    before = v if scheme.ahead == 0.0 else (1.0 - scheme.ahead) * v
    return System(
        scheme.h, before, v_free, residual, DenseFactors(L), exact, tangent, semidefinite=share,
        stiffened=stiffened if scheme.ahead == 0.0 else None,
        inertia=None if integration.static else at.inertia,
    )  # fmt: skip


def velocity_of_mass(mass: Array, v: Array) -> Array:
    """The velocity (r,) with the momentum of v (r,) and a mass (r, r), but none of what has no mass."""
    found, (own,) = np.zeros_like(v), np.nonzero(mass.diagonal() > 0.0)
    root = np.sqrt(mass.diagonal()[own])
    scaled = mass[own[:, None], own] / np.outer(root, root)
    inverse = np.linalg.pinv(scaled, MASSLESS, hermitian=True)
    found[own] = inverse @ (scaled @ (root * v[own])) / root
    return found


def with_drives_stiffer(
    tried: Iterator[Tangent],
    integration: Integration,
    mass: Array,
    material: Callable[[], Array],
    driven: Ints,
) -> Iterator[Tangent]:
    """What a step tries, and after the exact tangent the same with more on the diagonal of drives.

    As much more as a full body of tetrahedra adds (`tauten.model.constraints.ConstrainedBody.tangents`).

    Args:
        tried: without stiffer drives.
        integration: of the step.
        mass: (r, r).
        material: S of `implicit_step` (r, r) with the stiffness of the material.
        driven: (d,) unknowns that drives move.
    """
    for one in tried:
        yield one
        if one.exact:
            damping, stiffness = integration.shares
            S, D = one.values.copy(), material()[driven, driven] / (damping + stiffness)
            more = stiffness * D + 2.0 * np.abs(S[driven, driven] - damping * D)
            more += mass[driven, driven]
            S[driven, driven] += more
            yield Tangent(S, False, 0.0, (driven, more / stiffness))


def unheld_in(
    S: Array, h: float, driven: Ints | None, loose: Array | None
) -> tuple[Ints, Array] | None:
    """Unknowns of a static step that may go along with all else, see `Tangent`.

    Args:
        S: (r, r) of `implicit_step`, with the exact tangent.
        h: time step [s].
        driven: (d,) and
        loose: (r, r) as of `implicit_system`.
    """
    if loose is not None:
        held = np.abs(S.diagonal()) / h**2 + RATES[0] ** 2 * loose.diagonal()
        return np.arange(len(S)), held
    if driven is None or len(driven) == 0:
        return None
    return driven, S[driven, driven] / h**2


def with_mass(
    integration: Integration,
    exact: Array,
    semidefinite: Callable[[], Array],
    loose: Array | None,
) -> Iterator[Tangent]:
    """What a step tries, with the mass of what is loose after what is exact, and last.

    As a full body of tetrahedra adds it (`tauten.model.constraints.ConstrainedBody.tangents`).

    Args:
        integration: of the step.
        exact: (r, r) S of `implicit_step` with the derivative.
        semidefinite: gives S with the semidefinite tangent.
        loose: (r, r) mass; None: nothing is loose.
    """
    for one in tried_tangents(integration, exact, semidefinite):
        yield one
        if one.exact and loose is not None:
            yield Tangent(exact + (integration.h * RATES[0]) ** 2 * loose, False, 0.0)
    if loose is not None:
        for rate in RATES:
            yield Tangent(semidefinite() + (integration.h * rate) ** 2 * loose, False, 1.0)


def bounded_tangent(exact: Array, material: Array, others: Array) -> tuple[Array, bool, float]:
    """As little of the material's stiffness in the tangent as keeps A positive definite, with a margin.

    A of the result is at least `LEAST` of the matrix with the stiffness of the material, in every direction.
    It follows the state without jumps, as compliances have to from one decision to the next.

    Args:
        exact: (r, r) S of `implicit_step` with the derivative of the forces.
        material: (r, r) the same with the stiffness of the material.
        others: (r, r) what A has besides.

    Returns:
        S of `implicit_step`, whether it is that with the derivative, and the share of the other one.

    Raises:
        FactorisationError: a matrix is not finite, or that with the stiffness of the material is singular.
    """
    A, bound = exact + others, material + others
    if dpotrf(A - LEAST * bound)[1] == 0:
        return exact, True, 0.0
    try:
        (least,) = eigh(A, bound, eigvals_only=True, subset_by_index=[0, 0])
    except (np.linalg.LinAlgError, ValueError) as error:  # ValueError: not finite
        raise FactorisationError("the reduced model's matrix is not positive definite") from error
    share = (LEAST - least) / (1.0 - least)
    return (1.0 - share) * exact + share * material, False, share
