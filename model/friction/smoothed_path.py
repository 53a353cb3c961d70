"""Contact forces at the end of a path through smoothed laws.

The smoothed law (F2) has a system that is never singular, and a solution near that of a law a little wider.
So its widths shrink from step to step, and the end of the path is a start from which Newton's steps on the
exact law need a few, also where contacts are redundant and these steps fail from anywhere else. With a width
of the largest |q| at first it does not matter where the path starts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauten.model.friction.problem import Cones
from tauten.model.friction.smoothed_law import (
    LinearLaw,
    Widths,
    law_error,
    law_size,
    linear_law,
    smoothed_law,
)
from tauten.model.numerics import Array, kernel

# Of the largest |q|, width κ k at the end: contacts that stick yield by its square
NARROWEST = 1e-5
GATE = 0.3  # error of the law, of its widths, up to which it counts as met
SHORTEST = 1.0 / 64.0  # of a step's line search
FULL = 0.9  # share of a step above which it counts as a full one


class Width(NamedTuple):
    """How wide the smoothed law is at first, and how fast it becomes narrow.

    Attributes:
        share: κ.
        length: displacement that sets the widths.
        shrink: factor of κ after a full step; its root after a shortened one.
    """

    share: float
    length: float
    shrink: float


@kernel
def smoothed_forces(
    cones: Cones, G: Array, start: Array, wide: Width, steps: int
) -> tuple[Array, int]:
    """Forces (3 m,) at the end of the path, and linear systems.

    Args:
        cones: the contacts, of three rows.
        G: (3 m, rank) of the state form, see `linear_law`.
        start: (3 m,) forces to start from.
        wide: at first.
        steps: at most.
    """
    narrowest = NARROWEST * np.abs(cones.q).max() / wide.length
    each, none, r = np.full(len(cones.mu), wide.length), np.empty((len(start), 0)), start
    width = Widths(wide.share, each)
    for step in range(steps):
        law = linear_law(cones, G, r, width, none)
        if not np.isfinite(law.residual).all():
            return r, step + 1
        F, r, share = shortened(cones, r, law, width)
        if law_error(width, F) <= GATE:
            if width.share <= narrowest:
                return r, step + 1
            factor = wide.shrink if share > FULL else np.sqrt(wide.shrink)
            width = Widths(factor * width.share, each)
    return r, steps


@kernel
def shortened(cones: Cones, r: Array, law: LinearLaw, width: Widths) -> tuple[Array, Array, float]:
    """A step of the forces by line search on |F|: F (m, 3) and r (3 m,) after it, and its share.

    Args:
        cones: the contacts.
        r: (3 m,) forces.
        law: linearised at these.
        width: of the law.
    """
    change = law.residual
    share, before = 1.0, law_size(width, law.F)
    du = np.dot(cones.W, change).reshape(law.u.shape)
    while True:
        there = r + share * change
        after = smoothed_law(cones, law.u + share * du, there, width)
        lower = law_size(width, after) < (1.0 - 1e-4 * share) * before
        if lower or 0.5 * share < SHORTEST:
            return after, there, share
        share *= 0.5
