"""Factors of a block-diagonal matrix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Factorisation


@dataclass(slots=True, eq=False)
class BlockFactors:
    """Factors of the block of each part; a `Factorisation`.

    Attributes:
        parts: factors of each part.
        columns: unknowns of each part.
        stored: values of each part among those of all parts.
        shapes: of the values of each part as its body stores them.
    """

    parts: tuple[Factorisation, ...]
    columns: tuple[slice, ...]
    stored: tuple[slice, ...]
    shapes: tuple[tuple[int, ...], ...]

    @property
    def name(self) -> str:
        """Names of the solvers of all parts."""
        return " and ".join(dict.fromkeys(part.name for part in self.parts))

    def refactor(self, values: Array) -> None:
        """Factorise the matrix with these values, part by part.

        Raises:
            FactorisationError: a block is not positive definite or not finite.
        """
        for part, span, shape in zip(self.parts, self.stored, self.shapes, strict=True):
            part.refactor(values[span].reshape(shape))

    def solve(self, B: Array) -> Array:
        """A⁻¹ B for B (n,) or (n, m): each block with the columns that are not zero there."""
        if len(self.parts) == 1:
            return self.parts[0].solve(B)
        X = np.zeros(B.shape, order="F")
        for part, span in zip(self.parts, self.columns, strict=True):
            block = B[span]
            if B.ndim == 1:
                X[span] = part.solve(block)
                continue
            used = np.flatnonzero(block.any(axis=0))
            if len(used) > 0:
                X[span, used] = part.solve(np.asfortranarray(block[:, used]))
        return X

    def fork(self) -> Factorisation:
        """A workspace of its own for the same pattern, without factors."""
        parts = tuple(part.fork() for part in self.parts)
        return BlockFactors(parts, self.columns, self.stored, self.shapes)
