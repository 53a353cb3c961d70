"""Anderson acceleration of a fixed-point iteration q ← q ⊕ f(q)."""

from __future__ import annotations

import numpy as np

from tauten.model.numerics.arrays import Array


class Anderson:
    """Combines the last iterates so that the linear part of the error vanishes.

    A Newton iteration whose tangent is incomplete (without the rotation of contact normals, for example)
    converges linearly, with few slow directions, which the combination removes. (Anderson 1965; in the
    form of Walker and Ni, Anderson Acceleration for Fixed-Point Iterations, 2011.)
    """

    def __init__(self, depth: int) -> None:
        """Keep at most `depth` differences of iterates."""
        self._depth = depth
        self._steps: list[Array] = []  # f(q)
        self._moves: list[Array] = []  # by which the iterates moved

    def restart(self) -> None:
        """Forget the iterates so far."""
        self._steps.clear()
        self._moves.clear()

    def next(self, step: Array) -> Array:
        """The move (n,) to make where the plain iteration would make `step` (n,).

        Only increments enter, so configurations need not be a vector space; where they are not, a
        move counts as if made from the next iterate, which small steps allow.
        """
        if self._steps and np.abs(step).max() > 2.0 * np.abs(self._steps[-1]).max():
            self.restart()  # the set of contacts has changed: earlier iterates belong to another problem
        self._steps = [*self._steps[-self._depth :], step]
        self._moves = self._moves[-self._depth :]
        move = step
        if len(self._steps) > 1:
            dF = np.diff(self._steps, axis=0).T  # (n, m)
            dQ = np.array(self._moves).T  # (n, m)
            gamma = np.linalg.lstsq(dF, step, rcond=1e-10)[0]  # (m,)
            move = step - (dQ + dF) @ gamma
        self._moves.append(move)
        return move
