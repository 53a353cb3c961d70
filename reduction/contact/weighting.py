"""Weights of the snapshots in a factorisation."""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

import numpy as np

from tauten.model.numerics import Array

Weighting: TypeAlias = Literal["equal", "force"]
WEIGHTINGS: tuple[Weighting, ...] = get_args(Weighting)

# Smallest norm in a weight, as a share of the largest norm: limits the weight of snapshots where only a
# single candidate is in contact.
_FLOOR = 1e-3


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
