"""Weights and tolerances of decisions."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.controller.friction import FrictionSettings
from tauten.controller.qpcc import QpccSettings, TimeLimit
from tauten.model import Enrichment, ForceLimits

# Of the coefficients of friction. Decisions squeeze to the border of what they count on: a grasp that carries
# a weight W counts on W / (share μ). With 20 % less friction and 20 % more mass than the model has it needs
# 1.2 W / (0.8 μ), so that the share must be less than 0.8 / 1.2.
FRICTION_SHARE = 0.66
PATH_STEPS, DESCENT = 25, 3  # of a plan with friction
LONG_PATH = 60  # of one that looks for contact


@dataclass(frozen=True, slots=True)
class DecideSettings:
    """Weights and tolerances of `decide`.

    Attributes:
        epsilon: weight of the actuation energy in (T1), unitless.
        enrichment: when unit columns join the basis.
        qpcc: settings of the solver.
        substeps: of second order that the model takes in a tick; 0: the decision's own step.
        friction_share: of the coefficients of friction, that plans count on.
        forces: limits of contact forces; None: there are none.
        time: after which plans with friction end with the best that they have; None: no limit.
        seeking: whether a plan looks for contact because no effort moves the effectors without it.
    """

    epsilon: float
    enrichment: Enrichment
    qpcc: QpccSettings
    substeps: int = 1
    friction_share: float = FRICTION_SHARE
    forces: ForceLimits | None = None
    time: TimeLimit | None = None
    seeking: bool = False

    @property
    def search(self) -> FrictionSettings:
        """How far a search with friction may go that begins now."""
        solves = 2 * self.qpcc.max_pivots
        steps = LONG_PATH if self.seeking else PATH_STEPS
        return FrictionSettings(
            self.qpcc.solver, solves, self.time, steps, DESCENT, True, self.seeking
        )
