"""Factors of a block-diagonal matrix."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Factorisation, HalfSolving


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
        return self._each([part.solve for part in self.parts], B)

    def _each(self, solvers: Sequence[Callable[[Array], Array]], B: Array) -> Array:
        """What solvers, one for each part, make of B, of the columns that are not zero in a part."""
        if len(solvers) == 1:
            return solvers[0](B)
        X = np.zeros(B.shape, order="F")
        for solve, span in zip(solvers, self.columns, strict=True):
            block = B[span]
            if B.ndim == 1:
                X[span] = solve(block)
                continue
            used = np.flatnonzero(block.any(axis=0))
            if len(used) > 0:
                X[span, used] = solve(np.asfortranarray(block[:, used]))
        return X

    def fork(self) -> Factorisation:
        """A workspace of its own for the same pattern, without factors."""
        parts = [part.fork() for part in self.parts]
        return block_factors(parts, self.columns, self.stored, self.shapes)


@dataclass(slots=True, eq=False)
class HalfBlockFactors(BlockFactors, HalfSolving):
    """The same where those of each part solve by halves."""

    parts: tuple[HalfSolving, ...]

    def first_half(self, B: Array) -> Array:
        """See `HalfSolving`."""
        return self._each([part.first_half for part in self.parts], B)

    def second_half(self, Y: Array) -> Array:
        """See `HalfSolving`."""
        return self._each([part.second_half for part in self.parts], Y)


def block_factors(
    parts: Sequence[Factorisation],
    columns: tuple[slice, ...],
    stored: tuple[slice, ...],
    shapes: tuple[tuple[int, ...], ...],
) -> BlockFactors:
    """Factors of each part as those of all parts, by halves where those of each part solve so."""
    halves = tuple(part for part in parts if isinstance(part, HalfSolving))
    if len(halves) == len(parts):
        return HalfBlockFactors(halves, columns, stored, shapes)
    return BlockFactors(tuple(parts), columns, stored, shapes)
