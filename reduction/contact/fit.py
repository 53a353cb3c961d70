"""Modes from weighted snapshots by any method, and their errors on contact problems."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, get_args

import numpy as np

from tauten.model.numerics import Array
from tauten.reduction.contact.energy import MAX_SWEEPS, energy_error, refine, worst_forces
from tauten.reduction.contact.positive_basis import METHODS, Method, factorise_each
from tauten.reduction.contact.problems import ContactProblem

BasisMethod: TypeAlias = Literal["energy"] | Method
BASIS_METHODS: tuple[BasisMethod, ...] = ("energy", *METHODS)
Weighting: TypeAlias = Literal["equal", "force"]
WEIGHTINGS: tuple[Weighting, ...] = get_args(Weighting)
# Smallest norm in a weight, as a share of the largest norm: limits the weight of snapshots where only a
# single candidate is in contact.
_FLOOR = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Contact modes and the error of their factorisation.

    Attributes:
        Psi: (n_c, k) contact modes, unit columns.
        error: ‖S − Ψ B‖_F / ‖S‖_F of the factorisation; for "energy" that of its start.
        requested: number of modes requested; "als" may drop some, which then have no force.
    """

    Psi: Array
    error: float
    requested: int

    @property
    def k(self) -> int:
        """Number of modes."""
        return int(self.Psi.shape[1])


def fit_each(
    S: Array,
    problems: Sequence[ContactProblem],
    ks: Sequence[int],
    method: BasisMethod = "energy",
    seed: int = 0,
    max_sweeps: int = MAX_SWEEPS,
) -> tuple[Fit, ...]:
    """Modes for several k, ascending.

    Args:
        S: (n_c, s) weighted contact forces, see `factorise`.
        problems: equilibria for "energy", see `refine`.
        ks: numbers of modes.
        method: "energy": HALS, then descent in energy, which ends no higher than with fewer modes; or a
            method of `factorise`.
        seed: see `factorise`.
        max_sweeps: see `refine`.

    Raises:
        ValueError: as `factorise`.
    """
    start: Method = "hals" if method == "energy" else method
    fits = [
        Fit(found.Psi, found.error, k)
        for k, found in zip(sorted(set(ks)), factorise_each(S, ks, start, seed), strict=True)
    ]
    return tuple(fits if method != "energy" else _of_least_energy(fits, problems, max_sweeps))


def _of_least_energy(
    fits: Sequence[Fit], problems: Sequence[ContactProblem], max_sweeps: int
) -> list[Fit]:
    """Descent in energy from each fit; more modes never lose more energy than fewer did.

    Descent ends at a local minimum. Where that of k modes loses more than the last, smaller basis, it begins
    again from this basis and the forces of the problems in which it loses most.
    """
    refined: list[Fit] = []
    least = np.inf
    for fit in fits:
        Psi, history = refine(fit.Psi, problems, max_sweeps)
        if history[-1] > least:
            worst = worst_forces(refined[-1].Psi, problems, fit.k - refined[-1].k)
            Psi, history = refine(np.hstack([refined[-1].Psi, worst]), problems, max_sweeps)
        least = float(history[-1])
        refined.append(replace(fit, Psi=Psi))
    return refined


@dataclass(frozen=True, slots=True)
class BasisQuality:
    """Errors of modes on contact problems, all to first order.

    Attributes:
        energy: √ of the lost share of the energy: 0 exact, 1 without contact forces.
        force: largest error of the sum of contact forces [N].
        tip: largest error of an effector position [m].
    """

    energy: float
    force: float
    tip: float


def quality(Psi: Array, problems: Sequence[ContactProblem]) -> BasisQuality:
    """Quality of modes Psi (n_c, k)."""
    forces = [problem.forces(Psi) for problem in problems]
    pairs = list(zip(problems, forces, strict=True))
    return BasisQuality(
        energy=energy_error(Psi, problems),
        force=float(np.max([problem.force_error(lam) for problem, lam in pairs])),
        tip=float(np.max([problem.tip_error(lam) for problem, lam in pairs])),
    )


def snapshot_weights(S: Array, weighting: Weighting) -> Array:
    """Factors (s,) for the columns of S (n_c, s) [N] before the factorisation.

    "force" is the paper's choice: factors 1, so the strongest contacts dominate the error. "equal" scales the
    columns to unit length: a cone does not depend on the lengths of its generators, which the reduced LCP
    computes, so weak and strong patterns of force have the same weight.

    Raises:
        ValueError: unknown weighting.
    """
    if weighting not in WEIGHTINGS:
        raise ValueError(f"weighting {weighting!r} is unknown: one of {', '.join(WEIGHTINGS)}")
    if weighting == "force":
        return np.ones(S.shape[1])
    norms = np.linalg.norm(S, axis=0)  # (s,)
    weights: Array = 1.0 / np.maximum(norms, max(_FLOOR * norms.max(initial=0.0), 1e-300))
    return weights
