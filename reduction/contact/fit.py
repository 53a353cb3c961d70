"""Modes from snapshots by any method, and how good they are on contact problems."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from tauten.model.numerics import Array
from tauten.reduction.contact.energy import MAX_SWEEPS, energy_error, refine
from tauten.reduction.contact.positive_basis import METHODS, Method, factorise_each
from tauten.reduction.contact.problems import ContactProblem

BasisMethod: TypeAlias = Literal["energy"] | Method
BASIS_METHODS: tuple[BasisMethod, ...] = ("energy", *METHODS)


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Modes and what they were fitted to.

    Attributes:
        Psi: (n_c, k) contact modes, unit columns.
        error: ‖S − Ψ B‖_F / ‖S‖_F of the factorisation; for "energy" that of its start.
        asked: number of modes asked for; "als" may kill some.
    """

    Psi: Array
    error: float
    asked: int

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
        problems: equilibria that "energy" descends on, see `refine`.
        ks: numbers of modes.
        method: "energy": HALS, then descent in energy; or a method of `factorise`.
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
    if method == "energy":
        fits = [replace(fit, Psi=refine(fit.Psi, problems, max_sweeps)[0]) for fit in fits]
    return tuple(fits)


@dataclass(frozen=True, slots=True)
class Quality:
    """How good modes are on contact problems, all to first order.

    Attributes:
        energy: √ of the share of the energy that is lost: 0 exact, 1 no contact at all.
        force: largest error of the sum of contact forces [N].
        tip: largest displacement of an effector from its place [m].
    """

    energy: float
    force: float
    tip: float


def quality(Psi: Array, problems: Sequence[ContactProblem]) -> Quality:
    """Quality of modes Psi (n_c, k)."""
    forces = [problem.forces(Psi) for problem in problems]
    pairs = list(zip(problems, forces, strict=True))
    return Quality(
        energy=energy_error(Psi, problems),
        force=float(np.max([problem.force_error(lam) for problem, lam in pairs])),
        tip=float(np.max([problem.tip_error(lam) for problem, lam in pairs])),
    )
