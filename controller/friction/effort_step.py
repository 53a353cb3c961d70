"""The QP for a change of the efforts, with contact forces that follow them in the first order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.controller.friction.problem import FrictionInverse
from tauten.controller.qpcc import UNBOUNDED, Backend, Qp, qp_backend
from tauten.model.numerics import Array

PULL = 100.0  # weight of violated limits against the objective, by their curvatures
BEYOND = 1e-9  # of the largest row value, violation of a limit that is pulled back


@dataclass(frozen=True, slots=True)
class EffortStep:
    """A change of the efforts.

    Attributes:
        change: (n_a,).
        gain: by which the objective falls in the first order of the contact forces.
    """

    change: Array
    gain: float


@dataclass(frozen=True, slots=True)
class EffortProgram:
    """The inverse problem in the efforts alone, where forces follow them with a slope.

    Attributes:
        problem: limits and objective.
        solver: name of the QP library, or a function.
    """

    problem: FrictionInverse
    solver: str | Backend

    def objective(self, lam: Array, forces: Array) -> float:
        """The objective (I1) at efforts (n_a,) and forces on the problem's rows (s + 3 k,)."""
        return self.problem.program.objective(lam, forces)

    def excess(self, lam: Array, forces: Array) -> float:
        """Largest violation of the limits (I2), in the unit of their rows; bounds on λ are always met."""
        program = self.problem.program
        rows = program.G @ np.concatenate([lam, forces])
        return float(np.maximum(rows - program.g_hi, program.g_lo - rows).max(initial=0.0))

    def step(self, lam: Array, forces: Array, slope: Array, trust: Array) -> EffortStep | None:
        """The best change of the efforts; None where the QP has no solution.

        Limits contain the present point: a violated one does not become worse, and pulls.

        Args:
            lam: (n_a,) efforts.
            forces: (s + 3 k,) contact forces there, or where the law of contact leads from them.
            slope: (s + 3 k, n_a) of the forces.
            trust: (n_a,) largest change of each effort.
        """
        program, n_a = self.problem.program, len(lam)
        z, Z = np.concatenate([lam, forces]), np.concatenate([np.eye(n_a), slope])
        QZ = program.Q @ Z
        H, f = Z.T @ QZ, QZ.T @ z + Z.T @ program.c
        lb = np.minimum(np.maximum(program.lb - lam, -trust), 0.0)
        ub = np.maximum(np.minimum(program.ub - lam, trust), 0.0)
        A, rows = program.G @ Z, program.G @ z
        lo, hi = program.g_lo - rows, program.g_hi - rows
        H_all, f_all = H, f
        margin = BEYOND * float(np.abs(rows).max(initial=0.0))
        beyond = (lo > margin) | (hi < -margin)
        if beyond.any():
            B, gap = A[beyond], np.where(lo > margin, lo, hi)[beyond]
            weight = PULL * np.trace(H) / max(float((B * B).sum()), 1e-300)
            H_all, f_all = H + weight * B.T @ B, f - weight * B.T @ gap
        scale = 1.0 / np.sqrt(np.maximum(np.diag(H_all), 1e-300))  # variables of order one
        cost = max(float(np.abs(f_all * scale).max()), 1e-300)
        limited = np.isfinite(lo) | np.isfinite(hi)
        low = np.concatenate([lb / scale, np.minimum(lo, 0.0)[limited]]) / cost
        high = np.concatenate([ub / scale, np.maximum(hi, 0.0)[limited]]) / cost
        answer = qp_backend(self.solver)(
            Qp(
                scale[:, None] * H_all * scale,
                f_all * scale / cost,
                np.ascontiguousarray(A[limited] * scale),
                np.maximum(low, -UNBOUNDED),
                np.minimum(high, UNBOUNDED),
            )
        )
        if answer.infeasible or not np.isfinite(answer.y).all():
            return None
        change = np.clip(answer.y * cost * scale, lb, ub)
        return EffortStep(change, -float(f @ change + 0.5 * change @ H @ change))
