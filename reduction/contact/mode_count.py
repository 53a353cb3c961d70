"""Number of modes: error against k on snapshots held out of the factorisation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Ints
from tauten.reduction.campaign import Report, Snapshots
from tauten.reduction.contact.fit import BasisMethod, BasisQuality, fit_each, quality
from tauten.reduction.contact.positive_basis import checked_forces
from tauten.reduction.contact.problems import ContactProblem

DEFAULT_KS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40)
_SWEEPS = 12  # of the energy method: enough for a comparison of k
_BLOCKS = 40  # blocks of a single run, assigned to the folds in turn


class ChoiceError(ValueError):
    """No k is within the tolerance; the text names the error of the best one."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Error against the number of modes, one entry for each k; see `BasisQuality`.

    Attributes:
        k: (m,) numbers of modes, ascending.
        training: (m,) energy error on the problems the modes were fitted to.
        held_out: (m,) energy error on held-out problems, each held out once.
        force: (m,) largest error of the sum of contact forces in a held-out problem [N].
        tip: (m,) largest effector error in a held-out problem, to first order [m].
    """

    k: Ints
    training: Array
    held_out: Array
    force: Array
    tip: Array


def folds(snapshots: Snapshots, count: int = 4) -> Ints:
    """The fold in which each snapshot is held out: (s,), 0 … count − 1.

    Whole runs are held out together: neighbours within a run are nearly equal, so holding out single
    ones would not be a test. Where there are fewer runs than folds, runs are divided into blocks.
    """
    runs = np.unique(snapshots.run)
    if len(runs) >= count:
        return np.searchsorted(runs, snapshots.run) % count
    blocks = np.zeros(len(snapshots), dtype=np.int64)
    for run in runs:
        columns = np.flatnonzero(snapshots.run == run)
        blocks[columns] = np.arange(len(columns)) * _BLOCKS // len(columns)
    return blocks % count


def cross_validate(
    S: Array,
    fold: Ints,
    problems: Sequence[ContactProblem],
    ks: Sequence[int] = DEFAULT_KS,
    method: BasisMethod = "energy",
    seed: int = 0,
    report: Report = lambda share, what: None,
) -> Curve:
    """Error against k, training and held out.

    Args:
        S: (n_c, s) weighted contact forces.
        fold: (s,) the fold in which each column is held out.
        problems: contact problems of some of the columns.
        ks: numbers of modes; those beyond the rank of any training set are omitted.
        method: see `fit_each`.
        seed: see `factorise`.
        report: called with the share that is done since the last call, and with what is being done.

    Raises:
        ValueError: as `factorise`; or no k is within the rank.
    """
    S = checked_forces(S)
    parts = np.unique(fold[[problem.column for problem in problems]])
    rank = min(int(np.linalg.matrix_rank(S[:, fold != part])) for part in parts)
    usable = sorted({k for k in ks if 1 <= k <= rank})
    if not usable:
        raise ValueError(f"none of k = {list(ks)} lies in 1 to the rank of the snapshots, {rank}")
    training, held_out = [], []  # rows of BasisQuality, a part each
    for number, part in enumerate(parts, 1):
        what = f"errors of {usable[0]} to {usable[-1]} contact modes, part {number} of {len(parts)}"
        report(0.0, what)
        known = [problem for problem in problems if fold[problem.column] != part]
        unseen = [problem for problem in problems if fold[problem.column] == part]
        fits = fit_each(S[:, fold != part], known, usable, method, seed, _SWEEPS)
        training.append([quality(fit.Psi, known) for fit in fits])
        held_out.append([quality(fit.Psi, unseen) for fit in fits])
        report(1.0 / len(parts), what)
    return Curve(
        k=np.array(usable),
        training=_mean_energy(training),
        held_out=_mean_energy(held_out),
        force=np.array([[q.force for q in row] for row in held_out]).max(axis=0),
        tip=np.array([[q.tip for q in row] for row in held_out]).max(axis=0),
    )


def _mean_energy(rows: Sequence[Sequence[BasisQuality]]) -> Array:
    """Root mean square over the parts: (m,)."""
    errors: Array = np.sqrt(np.mean([[q.energy**2 for q in row] for row in rows], axis=0))
    return errors


def choose_k(curve: Curve, tolerance: float, needed: bool = True) -> int:
    """The smallest k whose held-out effector error is within the tolerance [m].

    Args:
        curve: errors against k.
        tolerance: [m].
        needed: whether an error beyond it is refused; otherwise the best k is taken then.

    Raises:
        ChoiceError: no k is within the tolerance; names the best one.
    """
    good = np.flatnonzero(curve.tip <= tolerance)
    if len(good) == 0:
        best = int(np.argmin(curve.tip))
        if not needed:
            return int(curve.k[best])
        raise ChoiceError(
            f"no k up to {curve.k[-1]} has a held-out effector error within {1e3 * tolerance:.3g} mm: "
            f"the best is {1e3 * curve.tip[best]:.3g} mm with k = {curve.k[best]}; raise the tolerance"
        )
    return int(curve.k[good[0]])
