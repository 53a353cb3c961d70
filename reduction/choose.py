"""How many modes: error against k on snapshots that took no part in the factorisation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tauten.model.arrays import Array, Ints
from tauten.reduction.cone import distances
from tauten.reduction.positive_basis import Method, checked, factorise_each
from tauten.reduction.snapshots import Snapshots
from tauten.reduction.weighting import Weighting, snapshot_weights

DEFAULT_KS = (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20, 25, 30, 40)
_BLOCKS = 40  # pieces a single run is cut into, dealt to the folds in turn


class ChoiceError(ValueError):
    """No k is good enough; the text says what the best one reaches."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Error against the number of modes, every entry for one k.

    Attributes:
        k: (m,) numbers of modes, ascending.
        training: (m,) ‖S − Ψ B‖_F / ‖S‖_F, the weighted snapshots factored themselves.
        held_out: (m,) the same over snapshots each held out once, with B ≥ 0 as good as Ψ allows.
        worst: (m,) largest force error of a held-out snapshot, Euclidean over the candidates [N].
    """

    k: Ints
    training: Array
    held_out: Array
    worst: Array


def folds(snapshots: Snapshots, count: int = 5) -> Ints:
    """Which fold holds out each snapshot: (s,), 0 … count − 1.

    Whole runs are held out together: neighbours within a run are nearly equal, and leaving out
    one of them would test nothing. A single run is cut into blocks instead.
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
    ks: Sequence[int] = DEFAULT_KS,
    method: Method = "hals",
    seed: int = 0,
    weighting: Weighting = "equal",
) -> Curve:
    """Error against k, training and held out.

    Args:
        S: (n_c, s) contact forces [N].
        fold: (s,) which fold holds out each column.
        ks: numbers of modes to look at; those beyond the rank of any training set are left out.
        method: see `factorise`.
        seed: see `factorise`.
        weighting: see `snapshot_weights`.

    Raises:
        ValueError: as `factorise`; or no k is within the rank.
    """
    S = checked(S)
    weights = snapshot_weights(S, weighting)  # (s,)
    weighted = S * weights
    parts = [(weighted[:, fold != f], weighted[:, fold == f]) for f in np.unique(fold)]
    rank = min(int(np.linalg.matrix_rank(training)) for training, _ in parts)
    usable = sorted({k for k in ks if 1 <= k <= rank})
    if not usable:
        raise ValueError(f"none of k = {list(ks)} lies in 1 to the rank of the snapshots, {rank}")
    training = [found.error for found in factorise_each(weighted, usable, method, seed)]
    missed = np.zeros((len(usable), S.shape[1]))  # (m, s), weighted
    for f, (known, held_out) in zip(np.unique(fold), parts, strict=True):
        for row, found in enumerate(factorise_each(known, usable, method, seed)):
            missed[row, fold == f] = distances(found.Psi, held_out)
    return Curve(
        k=np.array(usable),
        training=np.array(training),
        held_out=np.linalg.norm(missed, axis=1) / np.linalg.norm(weighted),
        worst=(missed / weights).max(axis=1),
    )


def choose_k(curve: Curve, tolerance: float) -> int:
    """The smallest k whose held-out error is within the tolerance.

    Raises:
        ChoiceError: none is; names the best.
    """
    good = np.flatnonzero(curve.held_out <= tolerance)
    if len(good) == 0:
        best = int(np.argmin(curve.held_out))
        raise ChoiceError(
            f"no k up to {curve.k[-1]} has a held-out error within {tolerance}: the best is "
            f"{curve.held_out[best]:.3g} with k = {curve.k[best]}; raise the tolerance"
        )
    return int(curve.k[good[0]])
