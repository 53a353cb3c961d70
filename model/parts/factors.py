"""Factors of a block-diagonal matrix, and the system of a step that has it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array, Factorisation, HalfSolving
from tauten.model.parts.spans import Spans, joined_forces
from tauten.model.system import System


@dataclass(slots=True, eq=False)
class BlockFactors:
    """Factors of the block of each part; a `Factorisation`.

    Attributes:
        parts: factors of each part.
        spans: where the numbers of each part are.
    """

    parts: tuple[Factorisation, ...]
    spans: Spans

    @property
    def name(self) -> str:
        """Names of the solvers of all parts."""
        return " and ".join(dict.fromkeys(part.name for part in self.parts))

    def refactor(self, values: Array) -> None:
        """Factorise the matrix with these values, part by part.

        Raises:
            FactorisationError: a block is not positive definite or not finite.
        """
        for part, span, shape in zip(self.parts, self.spans.stored, self.spans.shapes, strict=True):
            part.refactor(values[span].reshape(shape))

    def solve(self, B: Array) -> Array:
        """A⁻¹ B for B (n,) or (n, m): each block with the columns that are not zero there."""
        return self._each([part.solve for part in self.parts], B)

    def _each(self, solvers: Sequence[Callable[[Array], Array]], B: Array) -> Array:
        """What solvers, one for each part, make of B, of the columns that are not zero in a part."""
        if len(solvers) == 1:
            return solvers[0](B)
        X = np.zeros(B.shape, order="F")
        for solve, span in zip(solvers, self.spans.columns, strict=True):
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
        return block_factors([part.fork() for part in self.parts], self.spans)


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


def block_factors(parts: Sequence[Factorisation], spans: Spans) -> BlockFactors:
    """Factors of each part as those of all parts, by halves where those of each part solve so."""
    halves = tuple(part for part in parts if isinstance(part, HalfSolving))
    if len(halves) == len(parts):
        return HalfBlockFactors(halves, spans)
    return BlockFactors(tuple(parts), spans)


def joined_system(spans: Spans, systems: Sequence[System]) -> System:
    """The system of one step of all parts."""
    if len(systems) == 1:
        return systems[0]
    tangents = [one.tangent.ravel() for one in systems if one.tangent is not None]
    pairs = zip(spans.columns, systems, strict=True)
    stiffer = [
        (own.start + one.stiffened[0], one.stiffened[1]) for own, one in pairs if one.stiffened
    ]
    unknowns, more = zip(*stiffer, strict=True) if stiffer else ((), ())
    return System(
        h=systems[0].h,
        v=np.concatenate([one.v for one in systems]),
        v_free=np.concatenate([one.v_free for one in systems]),
        residual=float(np.linalg.norm([one.residual for one in systems])),
        factorisation=block_factors([one.factorisation for one in systems], spans),
        exact=all(one.exact for one in systems),
        tangent=np.concatenate(tangents) if len(tangents) == len(systems) else None,
        semidefinite=max(one.semidefinite for one in systems),
        stiffened=(np.concatenate(unknowns), np.concatenate(more)) if stiffer else None,
        inertia=joined_forces(spans, [one.inertia for one in systems]),
    )
