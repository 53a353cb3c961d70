"""The elastic energy of sampled elements, of which their forces are the derivative."""

from __future__ import annotations

import numpy as np

from tauten.model.materials import WORK, stress
from tauten.model.numerics import LANES, Array, kernel, polar_lanes
from tauten.reduction.state.tetra.arrays import SampledElements
from tauten.reduction.state.tetra.elements import add_gradients


@kernel
def sampled_energy(beta: Array, body: SampledElements) -> float:
    """The sum of energy densities times weighted volumes [J].

    Args:
        beta: (R,) [m].
        body: the elements.
    """
    F, R = np.empty(9 * LANES), np.empty(9 * LANES)
    own, turn, P, work = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty(WORK)
    energy = 0.0
    for block in range(body.gradient.shape[0]):
        for m in range(9 * LANES):
            F[m] = 1.0 if (m // LANES) % 4 == 0 else 0.0
        add_gradients(beta, body.gradient[block], F)
        polar_lanes(F, R)
        for k in range(LANES):
            for i in range(3):
                for j in range(3):
                    own[i, j] = F[(3 * i + j) * LANES + k]
                    turn[i, j] = R[(3 * i + j) * LANES + k]
            law = block * LANES + k
            stress(body.kind[law], body.constants[law], own, turn, P, work)
            energy += body.volume[block, k] * work[0]
    return energy
