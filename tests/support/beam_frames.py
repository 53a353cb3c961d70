"""Beams under dead loads, solved by Newton's method, for tests that need no robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from tauten.model import make_pattern
from tauten.model.beams import Beams, Material, Profile, assemble_beams, make_beams
from tauten.model.load import groups
from tauten.model.numerics import Array, Ints, turned


def chain(nodes: Array, up: Array, profile: Profile, material: Material) -> Beams:
    """Beams from node to node."""
    i = np.arange(len(nodes) - 1)
    ends: Ints = np.stack([i, i + 1], axis=1)
    return make_beams(nodes, ends, np.tile(up, (len(ends), 1)), [profile] * len(ends), material)


@dataclass
class Frame:
    """Beams held at node 0; x (n, 3) and Q (n, 4) move."""

    body: Beams

    def __post_init__(self) -> None:
        body = self.body
        fixed = np.zeros(2 * len(body.nodes), dtype=bool)
        fixed[:2] = True
        self.pattern = make_pattern(fixed, [groups(body.ends)])
        self.slots = self.pattern.blocks(groups(body.ends))
        self.x = body.nodes.copy()
        self.Q = np.tile([1.0, 0.0, 0.0, 0.0], (len(body.nodes), 1))

    def forces(self, exact: bool = True) -> tuple[Array, sp.csc_array, float]:
        """Internal forces on free nodes (n,), −∂force (n, n), energy."""
        body, pattern = self.body, self.pattern
        force, K = np.zeros((2 * len(body.nodes), 3)), np.zeros(len(pattern.indices))
        energy = assemble_beams(self.x, self.Q, body.arrays, exact, self.slots, force, K)
        matrix = sp.csc_array((K, pattern.indices, pattern.indptr))
        return force[pattern.dof >= 0].ravel(), matrix, energy

    def move(self, step: Array) -> None:
        """Move and turn the free nodes by (n,)."""
        parts = np.vstack([np.zeros(6), step.reshape(-1, 6)])
        self.x = self.x + parts[:, :3]
        self.Q = turned(self.Q, parts[:, 3:].copy())

    def solve(self, load: Array, tolerance: float = 1e-10, most: int = 60) -> list[float]:
        """Newton's method under a dead load on free nodes (n,), kept in hand as `Simulator.settle` does.

        Returns:
            The largest movement of each step.
        """
        moved = []
        for _ in range(most):
            force, K, _ = self.forces()
            if np.linalg.eigvalsh(K.toarray())[0] <= 0.0:
                force, K, _ = self.forces(exact=False)
            step = spsolve(K, force + load)
            moved.append(float(np.abs(step).max()))
            self.move(step * min(1.0, 0.05 * self.body.size / moved[-1]))
            if moved[-1] < tolerance:
                return moved
        raise AssertionError(f"no equilibrium: {moved[-5:]}")
