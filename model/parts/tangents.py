"""Forces and tangents of every part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array
from tauten.model.parts.motion import slices
from tauten.model.state import Assembled, Augmentation


@dataclass(frozen=True, slots=True)
class PartsAssembled(Assembled):
    """Forces and tangents of each part; attributes beside those of `Assembled`.

    Attributes:
        parts: as the body of each part assembled it.
    """

    parts: tuple[Assembled, ...]

    def augmentation(self, H: Array, rho: Array) -> tuple[Augmentation, Array]:
        """What adds ρ_i h_iᵀ h_i to tangents, of rows that are those of one part; see `Assembled`."""
        blocks = [H[:, span] for span in slices([len(part.state.v) for part in self.parts])]
        of_part = np.array([block.any(axis=1) for block in blocks])  # (p, m)
        alone, added, parts = of_part.sum(axis=0) == 1, np.zeros_like(rho), []
        for part, block, own in zip(self.parts, blocks, of_part, strict=True):
            made, found = part.augmentation(block, np.where(own & alone, rho, 0.0))
            parts.append(made)
            added += found
        return tuple(parts), added
