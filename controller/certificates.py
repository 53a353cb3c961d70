"""Certificates of holds, and how far efforts exceed their limits."""

from __future__ import annotations

import numpy as np

from tauten.controller.qpcc import Certificate
from tauten.model import Actuators, Command, ForwardStep, Limits
from tauten.model.numerics import Array, Bools


def beyond(effort: Array, limits: Limits, bilateral: Bools) -> Array:
    """How far efforts (n_a,) exceed their limits, relative to the largest magnitude: (n_a,), negative within.

    The least tension of a cable does not count: one that is held may be slack.

    Args:
        effort: (n_a,) [N, Pa].
        limits: of the actuators.
        bilateral: (n_a,) which actuators pull and push.
    """
    below = np.where(bilateral, limits.tension_min - effort, -np.inf)
    excess: Array = np.maximum(effort - limits.tension_max, below) / limits.largest_tension
    return excess


def hold_certificate(
    solved: ForwardStep, command: Command, limits: Limits, actuators: Actuators
) -> Certificate:
    """Residuals of a hold, relative to the row values and to the largest efforts.

    An LCP is the optimality condition of min ½ λᵀ W λ + δ_freeᵀ λ over λ ≥ 0: the gradient is δ, and the
    norm of min(w_ii λ_i, δ_i) is that of the projected gradient. That of a bilateral actuator is δ_i alone.

    Args:
        solved: forces and motion.
        command: position or effort that each actuator keeps.
        limits: of the actuators.
        actuators: which of them are bilateral; rows in the same unit have one scale.
    """
    step, acting = solved.prediction.step, solved.prediction.step.layout.acting
    lam, W = solved.prediction.lam[acting], step.compliance.W[acting, acting]
    n_a, by_force = step.layout.n_a, command.by_force
    delta_free = step.compliance.delta_free[acting].copy()
    delta_free[:n_a] -= np.where(by_force, 0.0, command.pull)
    delta, force = delta_free + W @ lam, np.diag(W) * lam  # (m,) m
    groups = np.concatenate([actuators.position_groups, np.zeros(len(lam) - n_a, np.int64)])
    size = np.maximum(np.abs(delta_free), np.abs(force))
    scale = np.array([size[groups == groups[i]].max() for i in range(len(size))])  # (m,)
    scale = np.where(scale > 0.0, scale, 1.0)
    kept = np.concatenate([~by_force, np.ones(len(lam) - n_a, np.bool_)])
    zero = np.concatenate([actuators.bilateral, np.zeros(len(lam) - n_a, np.bool_)])
    residual = np.where(zero, delta, np.minimum(force, delta))[kept] / scale[kept]
    violation = (np.where(zero, np.abs(delta), -delta) / scale)[kept]
    excess = beyond(lam[:n_a], limits, actuators.bilateral)
    return Certificate(
        primal=max(0.0, float(violation.max(initial=0.0)), float(excess.max(initial=0.0))),
        complementarity=float(np.abs(residual).max(initial=0.0)),
        stationarity=float(np.linalg.norm(residual)),
        deepest_gap=solved.prediction.deepest_gap,
        extra_columns=len(step.extra),
    )
