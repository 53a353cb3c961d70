"""How much each snapshot counts in a factorisation."""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

import numpy as np

from tauten.model.numerics import Array

Weighting: TypeAlias = Literal["equal", "force"]
WEIGHTINGS: tuple[Weighting, ...] = get_args(Weighting)

# Snapshots with less than this share of the largest force count as if they had it: the first touch
# of a single candidate shall not outweigh the rest.
_FLOOR = 1e-3


def snapshot_weights(S: Array, weighting: Weighting) -> Array:
    """Factors for the columns of S before they are factored: (s,).

    "force" is the paper's: every newton counts the same, so the strongest contacts decide. "equal"
    brings the columns to unit length: a cone does not know how long its generators are, the reduced
    LCP finds the lengths by itself, and what has to be learned is the patterns of force, weak ones as
    well as strong ones.

    Args:
        S: (n_c, s) contact forces [N].
        weighting: "equal" or "force".

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
