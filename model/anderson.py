"""Anderson acceleration of a fixed-point iteration q ← g(q)."""

from __future__ import annotations

import numpy as np

from tauten.model.arrays import Array


class Anderson:
    """Combines the last iterates so that the linear part of the error vanishes.

    A Newton iteration whose tangent leaves something out (how contact normals turn, say) converges
    linearly, with few slow directions; these are what the combination removes. (Anderson 1965; in the
    form of Walker and Ni, Anderson Acceleration for Fixed-Point Iterations, 2011.)
    """

    def __init__(self, depth: int) -> None:
        """Keep at most `depth` differences of iterates."""
        self._depth = depth
        self._steps: list[Array] = []  # f = g(q) − q
        self._images: list[Array] = []  # g(q)

    def next(self, q: Array, image: Array) -> Array:
        """The next iterate after g(q) = image, both (n,)."""
        step = image - q
        if self._steps and np.abs(step).max() > 2.0 * np.abs(self._steps[-1]).max():
            self._steps.clear()  # what touches has changed: the past says nothing any more
            self._images.clear()
        self._steps = [*self._steps[-self._depth :], step]
        self._images = [*self._images[-self._depth :], image]
        if len(self._steps) < 2:
            return image
        dF = np.diff(self._steps, axis=0).T  # (n, m)
        dG = np.diff(self._images, axis=0).T  # (n, m)
        gamma = np.linalg.lstsq(dF, step, rcond=1e-10)[0]  # (m,)
        combined: Array = image - dG @ gamma
        return combined
