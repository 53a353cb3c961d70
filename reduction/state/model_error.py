"""How far a reduced model has taken the tip from where the full one would have it, asked at one state."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from tauten.model import ContactSpace, Simulator, State, default_enrichment
from tauten.model.numerics import Array, FactorisationError
from tauten.reduction.state.robot import ReducedRobot

STEPS = 3  # Newton steps towards equilibrium; the first finds what the basis cannot follow to first order


class TipCheck:
    """Compares a reduced model with the full one, each with a workspace of its own.

    Both take a few Newton steps towards equilibrium from the same state under the same pulled lengths, the
    full one with pointwise contact. Where the tips end apart, forces of the full model push in directions
    that the state basis, the sampled elements or the contact modes do not have. Inertia and damping, which
    are in neither, do not matter.
    """

    def __init__(
        self, robot: ReducedRobot, contact: Literal["none", "full"] | ContactSpace
    ) -> None:
        """Compare this robot, with the contact that its controller knows."""
        enrichment = default_enrichment(robot.config.contact.tolerance)
        known = None if isinstance(contact, str) else enrichment
        self._robot = robot
        self._reduced = Simulator(robot, contact, known)
        self._full = Simulator(robot.full, "none" if contact == "none" else "full")

    def __call__(self, state: State, tension: Array, pull: Array) -> float:
        """Largest distance of an effector between the two models [m]; +inf where either breaks down.

        Args:
            state: of the reduced model.
            tension: (n_a,) cable tensions there [N].
            pull: (n_a,) pulled lengths that both are to reach [m].
        """
        try:
            apart = self._settled(self._reduced, state, tension, pull) - self._settled(
                self._full, self._robot.lifted(state), tension, pull
            )
        except FactorisationError:
            return np.inf
        distance = float(np.linalg.norm(apart, axis=1).max())
        return distance if np.isfinite(distance) else np.inf

    def _settled(self, simulator: Simulator, state: State, tension: Array, pull: Array) -> Array:
        """Effectors (p, 3) after a few steps towards equilibrium [m]."""
        simulator.reset()
        simulator.state = state
        simulator.forces = replace(simulator.forces, tension=tension)
        simulator.settle(pull=pull, max_iterations=STEPS)
        return simulator.effector
