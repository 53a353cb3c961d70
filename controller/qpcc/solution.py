"""What a decision returns: the solution, how it ended, and the certificate that judges it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from math import inf, isfinite

from tauten.model.numerics import Array, Bools


class Status(Enum):
    """How a solve ended; the value is the advice to the person who reads it."""

    OK = "stationary point within tolerance"
    FEASIBLE_ONLY = "feasible but not shown stationary: raise the pivot limit or the time budget"
    INFEASIBLE = "no tensions satisfy the limits: widen the named limits or slow the target down"
    MAX_PIVOTS = "pivot limit reached: raise max_pivots; the best point found is returned"
    NOT_FINITE = "NaN or infinity in the problem: look at the target and the model state"

    @property
    def ok(self) -> bool:
        """Whether the answer is as good as was asked for."""
        return self is Status.OK

    @property
    def usable(self) -> bool:
        """Whether the answer satisfies limits and contacts, so that robot and model may follow it."""
        return self in (Status.OK, Status.FEASIBLE_ONLY, Status.MAX_PIVOTS)


@dataclass(frozen=True, slots=True)
class Certificate:
    """Residuals of a solution, computed from the problem alone, whichever solver made it.

    Attributes:
        primal: largest violation of bounds and limits, relative to the problem's scale.
        complementarity: largest min(β_i, δ_i) after scaling both, 0 ≤ δ ⟂ β ≥ 0 (9).
        stationarity: norm of the projected gradient of the Lagrangian, relative.
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
        pivots: number of pieces solved.
        piece: (k,) bool, True where a mode pushes (δ_i = 0), False where it is open (β_i = 0).
        conflict: names or indices of the limits that conflict, when INFEASIBLE.
        bound: no feasible point has a lower objective; -inf when no search was asked for one.
    """

    lam_a: Array
    beta: Array
    status: Status
    certificate: Certificate
    objective: float
    pivots: int
    piece: Bools
    conflict: tuple[str, ...] = ()
    bound: float = -inf

    @property
    def gap(self) -> float:
        """How far the objective may lie above the global optimum, relative; +inf when unknown."""
        if not (isfinite(self.objective) and isfinite(self.bound)):
            return inf
        excess = self.objective - self.bound
        return 0.0 if excess <= 0.0 else excess / max(abs(self.objective), abs(self.bound))
