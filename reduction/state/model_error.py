"""Tip error of a reduced model at one state: its distance from the full model after a few Newton steps."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from tauten.model import ContactSpace, Ending, Robot, Simulator, State, default_enrichment
from tauten.model.contact import ObstaclePose
from tauten.model.numerics import Array
from tauten.reduction.reduced_body import ReducedBody
from tauten.reduction.state.parts import ReducedParts

STEPS = 3  # Newton steps towards equilibrium; the first one shows the error to first order


class TipCheck:
    """Compares a reduced model with the full one, each with its own workspace.

    Both take a few Newton steps towards equilibrium from the same state under the same pulled lengths, the
    full one with pointwise contact. Where the tips differ, the full model has forces in directions
    that the state basis, the sampled elements or the contact modes lack. Neither model has inertia or
    damping here.
    """

    def __init__(
        self,
        robot: Robot[ReducedBody | ReducedParts],
        contact: Literal["none", "full"] | ContactSpace,
    ) -> None:
        """Compare this robot, with the contact model of its controller."""
        enrichment = default_enrichment(robot.tolerance)
        chosen = None if isinstance(contact, str) else enrichment
        self._robot = robot
        self._reduced = Simulator(robot, contact, chosen)
        self._full = Simulator(robot.body.full, "none" if contact == "none" else "full")

    def __call__(
        self,
        state: State,
        effort: Array,
        position: Array,
        obstacles: tuple[ObstaclePose, ...] | None = None,
    ) -> float:
        """Largest error of an effector between the two models [m]; +inf where one of them diverges.

        Rotations and volumes count by their units, see `EffectorLayout.error`.

        Args:
            state: of the reduced model.
            effort: (n_a,) cable tensions there [N].
            position: (n_a,) pulled lengths that both are to reach [m].
            obstacles: where they are; None: where they start.
        """
        for simulator in (self._reduced, self._full):
            simulator.reset()
            if obstacles is not None:
                poses = replace(simulator.obstacles, poses=obstacles)
                simulator.set_obstacles(poses.still())
        found = self._settled(self._reduced, state, effort, position)
        wanted = self._settled(self._full, self._robot.body.lifted(state), effort, position)
        error = self._robot.effector_layout.error(found, wanted)
        return error if np.isfinite(error) else np.inf

    def _settled(self, simulator: Simulator, state: State, effort: Array, position: Array) -> Array:
        """Goal values (n_v,) of the effectors after a few steps towards equilibrium; NaN: it diverged."""
        simulator.start_from(state, replace(simulator.forces, effort=effort))
        report = simulator.settle(position=position, max_iterations=STEPS, load_steps=False)
        if report.ending is Ending.NOT_FINITE:
            return np.full_like(simulator.effector_values, np.nan)
        return simulator.effector_values
