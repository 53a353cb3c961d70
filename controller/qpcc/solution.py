"""What a solver returns: the solution, how it ended, and the residuals that certify it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property

from tauten.model.numerics import Array, Bools


class Status(Enum):
    """How a solve ended; the value is the advice to the person who reads it."""

    OK = "stationary point within tolerance; with friction the best point that was found"
    FEASIBLE_ONLY = "feasible but not shown stationary: raise the pivot limit or the time budget"
    NOT_FOUND = (
        "no feasible point found, nor shown that there is none: raise max_pivots or time_limit"
    )
    INFEASIBLE = "no tensions satisfy the limits: widen the named limits or slow the target down"
    MAX_PIVOTS = (
        "pivot or time limit reached: raise max_pivots or time_limit; the best point is returned"
    )
    NOT_EXACT = (
        "an exact effector cannot reach its target in this step, limits or contacts are in conflict with "
        "it: the nearest point is returned"
    )
    RELAXED = (
        "limits cannot all be met in this step: the actuators come as near to the named ones as their rates "
        "permit"
    )
    SEEKING_CONTACT = (
        "no descent in sight, seeking contact: everything sticks or touches nothing, and no efforts that "
        "bring the effectors nearer were found"
    )
    NOT_FINITE = (
        "no target of these effectors, by its shape or NaN, or NaN or infinity in the model's state"
    )

    @cached_property
    def ok(self) -> bool:
        """Whether the point is stationary, or with friction the best of a search that was not cut."""
        return self is Status.OK

    @cached_property
    def usable(self) -> bool:
        """Whether robot and model may follow: what leaves is within all limits."""
        return self not in (Status.NOT_FOUND, Status.INFEASIBLE, Status.NOT_FINITE)


@dataclass(frozen=True, slots=True)
class Certificate:
    """Residuals of a solution, computed from the problem alone, whichever solver made it.

    Attributes:
        primal: largest violation of bounds and limits, relative to the problem's scale.
        complementarity: largest min(β_i, δ_i) after scaling both, 0 ≤ δ ⟂ β ≥ 0 (9).
        stationarity: norm of the projected gradient of the Lagrangian, relative. Of a decision with friction:
            square root of the share of the objective by which it promises to fall nearby, to first order.
        deepest_gap: smallest predicted gap over all candidates in range [m]; +inf without any.
            Negative values are penetrations.
        extra_columns: unit columns added to the basis for this step.
    """

    primal: float
    complementarity: float
    stationarity: float
    deepest_gap: float
    extra_columns: int = 0


@dataclass(frozen=True, slots=True)
class Solution:
    """A solved QPCC (T1).

    Attributes:
        lam_a: (n_a,) cable tensions [N].
        beta: (k,) reduced contact forces [N].
        status: how it ended.
        certificate: residuals.
        objective: value of the objective at the solution.
        pivots: number of QPs solved, one a piece.
        piece: (k,) bool, True where a mode pushes (δ_i = 0), False where it is open (β_i = 0).
        conflict: names or indices of the limits that conflict, when INFEASIBLE.
    """

    lam_a: Array
    beta: Array
    status: Status
    certificate: Certificate
    objective: float
    pivots: int
    piece: Bools
    conflict: tuple[str, ...] = ()
