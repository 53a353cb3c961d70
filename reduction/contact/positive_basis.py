"""One interface to all methods that make a positive basis from snapshots of contact forces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from tauten.model import one_blas_thread
from tauten.model.numerics import Array, Ints, coordinates
from tauten.reduction.contact.nnmf import Factors, als, hals, hals_nndsvd, relative_error

Method: TypeAlias = Literal["hals", "hals-nndsvd", "als", "greedy"]
METHODS: tuple[Method, ...] = get_args(Method)

# Negative forces up to this share of the largest one are rounding errors of the contact solver.
_NEGATIVE = 1e-9


@dataclass(frozen=True, slots=True)
class PositiveFactorisation:
    """S ≈ Ψ B with Ψ ≥ 0, B ≥ 0 and unit columns of Ψ (17).

    Attributes:
        Psi: (n_c, k) contact modes; "als" may drop some, then k is less than requested.
        B: (k, s) coefficients of the modes in every snapshot [N].
        error: ‖S − Ψ B‖_F / ‖S‖_F.
    """

    Psi: Array
    B: Array
    error: float

    @property
    def k(self) -> int:
        """Number of modes."""
        return int(self.Psi.shape[1])


def factorise(S: Array, k: int, method: Method = "hals", seed: int = 0) -> PositiveFactorisation:
    """Positive basis of k unit columns for the snapshots S (17).

    The order of the snapshots does not matter: they are sorted before the factorisation and B is put
    back into the given order after it, so a permuted S gives the same Ψ to the last bit. Linear algebra
    runs on one thread, so the number of threads does not matter either. Snapshots without contact and
    candidates that never touch take no part.

    Args:
        S: (n_c, s) contact forces [N], one snapshot a column.
        k: number of modes, at most the rank of S.
        method: "hals" (error never increases with k), "hals-nndsvd", "als" (the paper's Algorithm 1) or
            "greedy" (cone-projected greedy); sources in their docstrings.
        seed: of the random start of "als".

    Raises:
        ValueError: NaN or negative forces (names the columns), no contact in any snapshot, k
            larger than the rank, unknown method.
    """
    return factorise_each(S, (k,), method, seed)[0]


def factorise_each(
    S: Array, ks: Sequence[int], method: Method = "hals", seed: int = 0
) -> tuple[PositiveFactorisation, ...]:
    """As `factorise` for several k, ascending; "hals" and "greedy" compute all of them in one run.

    Args:
        S: (n_c, s) contact forces [N], one snapshot a column.
        ks: numbers of modes, each at most the rank of S.
        method: as in `factorise`.
        seed: of the random start of "als".

    Raises:
        ValueError: as `factorise`.
    """
    ks = sorted(set(ks))
    if method not in METHODS:
        raise ValueError(f"method {method!r} is unknown: choose one of {', '.join(METHODS)}")
    S = checked_forces(S)
    rows = np.flatnonzero((S > 0.0).any(axis=1))  # candidates in contact
    columns = np.flatnonzero((S > 0.0).any(axis=0))  # snapshots with contact
    columns = columns[np.lexsort(S[rows][:, columns])]
    core = np.ascontiguousarray(S[rows][:, columns])  # (n_c', s')
    _check_rank(core, ks)
    with one_blas_thread():  # the order of sums depends on the number of threads
        factors = _factors(core, ks, method, seed)
        return tuple(_unit_columns(S, rows, columns, found) for found in factors)


def _factors(S: Array, ks: Sequence[int], method: Method, seed: int) -> Iterator[Factors]:
    match method:
        case "hals":
            yield from (found for found in hals(S, ks[-1]) if len(found[1]) in ks)
        case "greedy":
            yield from (found for found in cone_projected_greedy(S, ks[-1]) if len(found[1]) in ks)
        case "hals-nndsvd":
            yield from (hals_nndsvd(S, k) for k in ks)
        case "als":
            yield from (als(S, k, seed) for k in ks)


def _unit_columns(S: Array, rows: Ints, columns: Ints, found: Factors) -> PositiveFactorisation:
    """Factors of S[rows, columns] as factors of S, with unit columns of Ψ."""
    Psi, B = found
    norms = np.linalg.norm(Psi, axis=0)  # (k,)
    nonzero = norms > 0.0
    full_Psi = np.zeros((S.shape[0], int(nonzero.sum())))
    full_B = np.zeros((int(nonzero.sum()), S.shape[1]))
    full_Psi[rows] = Psi[:, nonzero] / norms[nonzero]
    full_B[:, columns] = B[nonzero] * norms[nonzero, None]
    error = relative_error(S, full_Psi, full_B)
    return PositiveFactorisation(full_Psi, full_B, error)


def checked_forces(S: Array) -> Array:
    """Snapshots (n_c, s) as float64, negative rounding errors set to zero.

    Raises:
        ValueError: NaN or negative forces (names the columns), or no contact in any snapshot.
    """
    S = np.asarray(S, dtype=float)
    if S.ndim != 2:
        raise ValueError(
            f"snapshots have shape {S.shape}: expected (n_c, s), one snapshot a column"
        )
    bad = np.flatnonzero(~np.isfinite(S).all(axis=0))
    if len(bad):
        raise ValueError(
            f"snapshots hold NaN or infinite forces in {_columns(bad)}: drop those columns"
        )
    largest = S.max(initial=0.0)
    negative = np.flatnonzero((S + _NEGATIVE * largest < 0.0).any(axis=0))
    if len(negative):
        raise ValueError(
            f"snapshots hold negative forces in {_columns(negative)}: contacts only push (λ ≥ 0)"
        )
    if largest == 0.0:
        raise ValueError(
            f"none of the {S.shape[1]} snapshots has any contact force: "
            "pull further or load the robot so that it touches itself"
        )
    return np.maximum(S, 0.0)


def _check_rank(S: Array, ks: Sequence[int]) -> None:
    k = ks[-1]
    if ks[0] < 1:
        raise ValueError(f"k = {ks[0]} modes requested: at least 1 is needed")
    rank = int(np.linalg.matrix_rank(S))
    if k > rank:
        raise ValueError(
            f"k = {k} modes requested, but the snapshots have rank {rank}: "
            f"take k ≤ {rank} or a campaign with more variety"
        )


def _columns(index: Ints) -> str:
    names = ", ".join(str(i) for i in index[:5])
    more = f" and {len(index) - 5} more" if len(index) > 5 else ""
    return f"column{'s' if len(index) > 1 else ''} {names}{more}"


def cone_projected_greedy(S: Array, k: int) -> Iterator[Factors]:
    """Cone-projected greedy: next column = the snapshot farthest from the cone of those chosen.

    The cones are nested: neither the largest nor the mean distance increases with k, and the basis of
    k columns is the first k columns of any larger one. Every mode is a column of S.

    Args:
        S: (n_c, s) snapshots.
        k: number of snapshots to choose.

    Yields:
        For 1, 2, … k: the chosen columns Ψ (n_c, k) and the coordinates B (k, s) of the nearest
        points of their cone.

    Source: Benaceur, Ern, Ehrlacher, Int. J. Numerical Methods in Engineering 121, 2020.
    """
    chosen: list[int] = []
    residual = S
    for _ in range(k):
        distance = np.linalg.norm(residual, axis=0)  # (s,)
        distance[chosen] = -1.0  # zero except for rounding
        chosen.append(int(np.argmax(distance)))
        Psi: Array = S[:, chosen]
        B = coordinates(Psi, S)
        residual = S - Psi @ B
        yield Psi, B
