"""Certificates of holds."""

from __future__ import annotations

import numpy as np

from tauten.controller.qpcc import Certificate
from tauten.model import Actuators, Command, Limits, PredictedStep, sorted_rows


def hold_certificate(
    solved: PredictedStep, command: Command, limits: Limits, actuators: Actuators
) -> Certificate:
    """Residuals of a hold, relative to the row values and to the largest efforts.

    An LCP is the optimality condition of min ½ λᵀ W λ + δ_freeᵀ λ over λ ≥ 0: the gradient is δ, and the
    norm of min(w_ii λ_i, δ_i) is that of the projected gradient. That of a bilateral actuator is δ_i alone,
    that of contacts with friction the natural map of their cones.

    Args:
        solved: forces and motion.
        command: position or effort that each actuator keeps.
        limits: of the actuators.
        actuators: positions in the same unit have one scale.
    """
    step, layout = solved.step, solved.step.layout
    lam, W = solved.lam[layout.acting], step.compliance.W[layout.acting, layout.acting]
    rows = sorted_rows(step, command)
    delta_free = rows.delta[layout.acting]
    delta, force = delta_free + W @ lam, np.diag(W) * lam  # (m,) m
    groups = np.concatenate([actuators.position_groups, np.zeros(len(rows.contacts), np.int64)])
    size = np.maximum(np.abs(delta_free), np.abs(force))
    scale = np.array([size[groups == groups[i]].max() for i in range(len(size))])  # (m,)
    scale = np.where(scale > 0.0, scale, 1.0)
    unilateral = np.concatenate([rows.cables, step.gap_rows])
    equal, cables = rows.equal - layout.n_e, unilateral - layout.n_e
    residual, violation = np.zeros_like(delta), np.full_like(delta, -np.inf)
    residual[equal], violation[equal] = delta[equal], np.abs(delta[equal])
    residual[cables] = np.minimum(force, delta)[cables]
    violation[cables] = -delta[cables]
    residual, violation = residual / scale, violation / scale
    if step.frictional:  # of cones, not of rows one by one
        residual[step.gap_rows - layout.n_e] = solved.residual / scale[step.gap_rows - layout.n_e]
    excess = step.laws.beyond(solved.lam[layout.actuators], limits)
    return Certificate(
        primal=max(0.0, float(violation.max(initial=0.0)), float(excess.max(initial=0.0))),
        complementarity=float(np.abs(residual).max(initial=0.0)),
        stationarity=float(np.linalg.norm(residual)),
        deepest_gap=solved.deepest_gap,
        extra_columns=len(step.extra),
    )
